//! Lattices of any size, seed and cut.

use proptest::prelude::*;
use scene::lattice::{Cut, Lattice, LatticeRule};

fn doubled_area(lattice: &Lattice, triangle: usize) -> i64 {
    let [a, b, c] = lattice.corners(triangle).map(|v| lattice.nodes[v]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn triangles_face_up_and_tile_their_box(
        quads in 8_i64..40,
        cell_size in 20_000_i64..300_000,
        seed in any::<i64>(),
        cell in [-50_i64..50, -50_i64..50],
        kind in 0..3,
    ) {
        let shift = 2 * cell_size / quads / 5;
        let (cut, side) = match kind {
            0 => (Cut::Exact, cell_size),
            1 => (Cut::Overrun { margin: shift }, cell_size + 2 * shift),
            _ => (Cut::Ragged { reach: shift }, cell_size),
        };
        let lattice = Lattice::new(&LatticeRule { quads, cell_size, cut, seed }, cell, 0);
        let areas: Vec<i64> = (0..lattice.triangle_count()).map(|t| doubled_area(&lattice, t)).collect();
        prop_assert!(areas.iter().all(|&a| a > 0));
        if kind < 2 {
            prop_assert_eq!(areas.iter().sum::<i64>(), 2 * side * side);
        }
    }
}
