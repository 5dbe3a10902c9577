//! The same scene written down differently.

use super::{Scene, scatter};
use glam::{DVec2, DVec3};
use lacuna_grid::CellId;
use lacuna_mesh::TriMesh;
use std::collections::BTreeMap;

/// A change that leaves a scene's holes what they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// A quarter turn to the left about the origin.
    Turn,
    /// x becomes -x; triangles keep facing up.
    Mirror,
    /// By whole metres in x and y.
    Shift(f64, f64),
    /// Cells get other numbers.
    Renumber(i32, i32),
    /// Triangles in another order, and begun at another corner.
    ShuffleTriangles,
    /// Vertices in another order.
    ShuffleVertices,
}

impl Motion {
    /// The cell that `cell` becomes.
    pub(crate) fn cell(self, cell: CellId) -> CellId {
        match self {
            Self::Turn => CellId::new(-(cell.j + 1), cell.i),
            Self::Mirror => CellId::new(-(cell.i + 1), cell.j),
            Self::Renumber(i, j) => CellId::new(cell.i + i, cell.j + j),
            _ => cell,
        }
    }

    /// The scene after the change.
    pub(crate) fn of(self, scene: &Scene) -> Scene {
        let mut moved = scene.clone();
        moved.grid.origin = self.origin(scene);
        let tiles = scene.tiles.iter().map(|(&c, mesh)| (self.cell(c), self.mesh(mesh)));
        moved.tiles = tiles.collect::<BTreeMap<_, _>>();
        moved.unreadable = scene.unreadable.iter().map(|&c| self.cell(c)).collect();
        moved
    }

    fn origin(self, scene: &Scene) -> DVec2 {
        let (origin, size) = (scene.grid.origin, scene.grid.cell_size_m);
        match self {
            Self::Renumber(i, j) => origin - DVec2::new(f64::from(i), f64::from(j)) * size,
            Self::Turn | Self::Mirror | Self::Shift(..) => self.point(origin.extend(0.0)).truncate(),
            _ => origin,
        }
    }

    fn point(self, p: DVec3) -> DVec3 {
        match self {
            Self::Turn => DVec3::new(-p.y, p.x, p.z),
            Self::Mirror => DVec3::new(-p.x, p.y, p.z),
            Self::Shift(x, y) => p + DVec3::new(x, y, 0.0),
            _ => p,
        }
    }

    fn mesh(self, mesh: &TriMesh) -> TriMesh {
        let mut moved = mesh.clone();
        moved.positions.iter_mut().for_each(|p| *p = self.point(*p));
        match self {
            Self::Mirror => moved.triangles.iter_mut().for_each(|t| t.swap(1, 2)),
            Self::ShuffleTriangles => {
                moved.triangles = shuffled(moved.triangles.len()).map(|k| mesh.triangles[k]).collect();
                moved.triangles.iter_mut().enumerate().for_each(|(k, t)| t.rotate_left(k % 3));
            }
            Self::ShuffleVertices => {
                let order: Vec<usize> = shuffled(mesh.positions.len()).collect();
                let mut new = vec![0; order.len()];
                order.iter().enumerate().for_each(|(k, &old)| new[old] = k as u32);
                moved.positions = order.iter().map(|&old| mesh.positions[old]).collect();
                moved.triangles = mesh.triangles.iter().map(|t| t.map(|v| new[v as usize])).collect();
            }
            _ => {}
        }
        moved
    }
}

fn shuffled(count: usize) -> impl Iterator<Item = usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| scatter(a as i32, 3, 5).total_cmp(&scatter(b as i32, 3, 5)).then(a.cmp(&b)));
    order.into_iter()
}
