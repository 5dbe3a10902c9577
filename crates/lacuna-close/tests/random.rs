//! Random lakes close without a crack.

mod closing;
#[path = "../../lacuna-hole/tests/kit/mod.rs"]
mod kit;

use closing::close;
use kit::{Step, lattice};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn discs() -> impl Strategy<Value = Vec<Step>> {
    let disc = (0.0..24.0f64, 0.0..24.0f64, 0.4..6.0f64, prop::bool::weighted(0.75));
    let step = disc.prop_map(
        |(x, y, r, is_cut)| {
            if is_cut { Step::CutDisc(x, y, r) } else { Step::KeepDisc(x, y, 0.6 * r) }
        },
    );
    prop::collection::vec(step, 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        rng_seed: RngSeed::Fixed(20_210_731),
        failure_persistence: None,
        ..Default::default()
    })]

    #[test]
    fn discs_on_a_jittered_lattice(steps in discs(), growth in prop::sample::select(vec![0.0, 0.3])) {
        let scene = lattice(3, 3, 0.25, &steps);
        close(&scene, growth).check("discs");
    }
}
