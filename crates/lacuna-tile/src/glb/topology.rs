//! Which corners of a primitive's index stream form its triangles.

/// Places in the index stream of each triangle of a primitive (glTF 2.0, section 3.7.2.1).
///
/// Mode 4 takes three places each, mode 5 (strip) alternates so that the winding stays, mode 6 (fan) turns about the first.
/// Other modes have no triangles.
pub(super) fn triangles(mode: u64, corners: usize) -> impl Iterator<Item = [usize; 3]> {
    let count = triangle_count(mode, corners);
    (0..count).map(move |i| match mode {
        4 => [3 * i, 3 * i + 1, 3 * i + 2],
        5 => [i, i + 1 + i % 2, i + 2 - i % 2],
        _ => [i + 1, i + 2, 0],
    })
}

/// Number of triangles that `triangles` gives.
pub(super) fn triangle_count(mode: u64, corners: usize) -> usize {
    match mode {
        4 => corners / 3,
        5 | 6 => corners.saturating_sub(2),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_give_their_triangles() {
        let cases: [(u64, usize, &[[usize; 3]]); 8] = [
            (4, 7, &[[0, 1, 2], [3, 4, 5]]),
            (5, 5, &[[0, 1, 2], [1, 3, 2], [2, 3, 4]]),
            (6, 5, &[[1, 2, 0], [2, 3, 0], [3, 4, 0]]),
            (5, 2, &[]),
            (6, 0, &[]),
            (4, 2, &[]),
            (0, 9, &[]),
            (1, 9, &[]),
        ];
        for (mode, corners, expected) in cases {
            assert_eq!(
                triangles(mode, corners).collect::<Vec<_>>(),
                expected,
                "mode {mode}, {corners} corners"
            );
        }
    }
}
