//! What a scanned tile keeps in memory until the run ends.

use lacuna_hole::CellSurvey;
use std::mem::size_of;

/// What the allocator adds to a list, bytes.
const LIST_BYTES: u64 = 32;

/// What a tile takes in the list of the scene, in the plan and in its names, bytes (measured on 18,000 tiles).
const ENTRY_BYTES: u64 = 2 << 10;

/// Memory of a survey, bytes: its lists at the size they were given. (The previews of a scene have one size together,
/// however many tiles there are: they count as the program's own.)
pub(crate) fn kept_bytes(survey: &CellSurvey) -> u64 {
    let boundary = &survey.boundary;
    let loops: u64 = survey.loops.iter().map(|l| list_bytes(&l.edges)).sum();
    [
        ENTRY_BYTES,
        size_of::<CellSurvey>() as u64,
        list_bytes(&boundary.points),
        list_bytes(&boundary.edges),
        list_bytes(&boundary.copies),
        list_bytes(&boundary.duplicates),
        list_bytes(&survey.loops),
        loops,
        list_bytes(&survey.spacing_m),
        list_bytes(&survey.components),
        list_bytes(&survey.band.vertices),
        list_bytes(&survey.band.triangles),
        list_bytes(&survey.band.faces),
        survey.fans.bytes() + 2 * LIST_BYTES,
    ]
    .into_iter()
    .sum()
}

fn list_bytes<T>(list: &Vec<T>) -> u64 {
    (list.capacity() * size_of::<T>()) as u64 + LIST_BYTES
}

#[cfg(test)]
mod tests {
    use super::kept_bytes;
    use glam::DVec3;
    use lacuna_grid::CellId;
    use lacuna_hole::survey;
    use lacuna_mesh::TriMesh;

    /// Separate triangles: all of them lie on the boundary.
    fn confetti(count: u32) -> TriMesh {
        let mut mesh = TriMesh::default();
        for k in 0..count {
            let corner = DVec3::new(f64::from(k), 0.0, 0.0);
            mesh.positions.extend([corner, corner + DVec3::X * 0.5, corner + DVec3::Y]);
            mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        }
        mesh
    }

    #[test]
    fn a_boundary_ten_times_as_long_takes_ten_times_the_memory() {
        let bytes = |count| kept_bytes(&survey(CellId::new(0, 0), &confetti(count))) as f64;
        let (few, many) = (bytes(1_000), bytes(10_000));
        assert!((8.0..12.5).contains(&(many / few)), "{few} and {many} bytes");
        // Three points of 40 bytes and three edges of 48 are the least that a triangle's boundary can be.
        assert!(many > 10_000.0 * 3.0 * 88.0, "{many} bytes");
    }
}
