//! Tiles for cells that have none.

use crate::support::*;
use glam::DVec3;
use lacuna_tile::{NewTileRequest, ReadOptions, TileError, TileFormat, new_tile};
use serde_json::{Value, json};

#[test]
fn a_new_tile_rounds_like_its_template() {
    type Change = fn(&mut Value, &mut Vec<u8>);
    let cases: [(&str, Change); 5] = [
        ("plain", |_, _| {}),
        ("z up", |d, _| d["asset"]["gltfUpAxis"] = json!("Z")),
        ("extras", |d, _| d["asset"]["extras"] = json!({ "upAxis": "Z" })),
        ("far", |d, _| d["nodes"][0]["translation"] = json!([4_000_000.1, -2.5e6, 33.3])),
        ("RTC", |d, _| d["extensions"] = json!({ "CESIUM_RTC": { "center": [529_000, 5_020_000, 0] } })),
    ];
    for (name, change) in cases {
        let case = Case::new(&square_with(change));
        let frame = case.read().expect("read").frame;
        let near = case.read().expect("read").mesh.positions[0];
        let vertices: Vec<DVec3> = [[0.0, 0.0], [10.3, 0.1], [9.7, 8.9], [0.2, 10.1]]
            .map(|[x, y]| frame.round(near + DVec3::new(x, y, 0.3)))
            .to_vec();
        let request = NewTileRequest {
            template: &case.input(),
            output: &case.output(),
            format: TileFormat::Glb,
            options: &ReadOptions::default(),
            patches: &[free_patch(vertices.clone())],
        };
        new_tile(&request).unwrap_or_else(|e| panic!("{name}: {e}"));
        let made = case.read_output();
        assert_eq!(made.mesh.positions, vertices, "{name}");
        assert_eq!(made.mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{name}");
        assert_eq!(made.frame, frame, "{name}");
        let bad = NewTileRequest { patches: &[patch([0, 1], DVec3::ONE)], ..request };
        assert!(matches!(new_tile(&bad), Err(TileError::BadPatch { .. })), "{name}");
    }
}
