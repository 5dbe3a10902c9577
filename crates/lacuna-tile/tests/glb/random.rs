//! Invariants under random transforms and random damage.

use crate::support::*;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use serde_json::json;

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    /// Under any node transform rim copies come back bit for bit, and new vertices where they were asked for.
    #[test]
    fn patches_come_back_under_any_transform(
        translation in prop::array::uniform3(-1e6..1e6_f64),
        rotation in prop::array::uniform4(-1.0..1.0_f64),
        scale in prop::array::uniform3(prop_oneof![0.01..100.0_f64, -100.0..-0.01_f64]),
        corners in prop::array::uniform12(-1e3..1e3_f32),
        offset in prop::array::uniform3(-1e3..1e3_f64),
    ) {
        let rotation = DQuat::from_array(rotation);
        prop_assume!(rotation.length() > 0.1);
        let file = square_with(|d, b| {
            b.splice(..48, corners.iter().flat_map(|v| v.to_le_bytes()));
            d["nodes"][0] = json!({
                "mesh": 0, "translation": translation, "rotation": rotation.normalize().to_array(), "scale": scale,
            });
        });
        let case = Case::new(&file);
        let before = case.read().expect("read");
        let new = before.frame.round(before.mesh.positions[2] + DVec3::from_array(offset));
        case.append(&[patch([2, 1], new)]).expect("append");
        let after = case.read_output();
        check_originals("any", &before, &after);
        let patch = after.mesh.corners(2);
        let expected = [before.mesh.positions[2], before.mesh.positions[1], new];
        prop_assert_eq!(&patch[..2], &expected[..2]);
        prop_assert!((patch[2] - new).length() < 1e-8, "{} m away", (patch[2] - new).length());
    }

    /// Whatever the bytes are, reading ends with a tile or a typed error.
    #[test]
    fn random_damage_never_panics(damage in prop::collection::vec((0..2000_usize, any::<u8>()), 1..12)) {
        let mut file = square_with(|_, _| {});
        let length = file.len();
        for (at, byte) in damage {
            file[at % length] = byte;
        }
        if let Ok(tile) = read_bytes(&file) {
            prop_assert!(tile.mesh.triangles.iter().flatten().all(|&v| (v as usize) < tile.mesh.positions.len()));
        }
    }
}
