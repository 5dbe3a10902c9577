//! Dialects, frames, buffers.

use crate::support::*;
use glam::{DAffine3, DVec3};
use lacuna_tile::{ReadOptions, TileFormat, UpAxis, read_header, read_tile};
use serde_json::{Value, json};
use std::fs;

#[test]
fn dialects_read_as_listed() {
    type Change = fn(&mut Value, &mut Vec<u8>);
    let cases: [(&str, Change, &str); 19] = [
        ("plain, y up", |_, _| {}, UPRIGHT),
        (
            "z up by gltfUpAxis",
            |d, _| d["asset"]["gltfUpAxis"] = json!("Z"),
            "0,0,0 1,0,0 1,1,0 0,1,0 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "z up by extras",
            |d, _| d["asset"]["extras"] = json!({ "upAxis": "Z" }),
            "0,0,0 1,0,0 1,1,0 0,1,0 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "x up",
            |d, _| d["asset"]["gltfUpAxis"] = json!("X"),
            "0,0,0 0,0,1 0,1,1 0,1,0 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "no scene at all",
            |d, _| {
                d.as_object_mut().unwrap().remove("scene");
                d.as_object_mut().unwrap().remove("scenes");
            },
            UPRIGHT,
        ),
        (
            "first scene",
            |d, _| {
                d.as_object_mut().unwrap().remove("scene");
            },
            UPRIGHT,
        ),
        (
            "translation",
            |d, _| d["nodes"][0]["translation"] = json!([4e6, 0.5, 0]),
            "4000000,0,0.5 4000001,0,0.5 4000001,0,1.5 4000000,0,1.5 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "matrix",
            |d, _| d["nodes"][0]["matrix"] = json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1]),
            "1,0,0 3,0,0 3,0,2 1,0,2 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "mirror turns triangles",
            |d, _| d["nodes"][0]["scale"] = json!([1, 1, -1]),
            "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 2, 1], [0, 3, 2]]",
        ),
        (
            "CESIUM_RTC",
            |d, _| {
                d["extensions"] = json!({ "CESIUM_RTC": { "center": [10, 20, 0] } });
                d["extensionsRequired"] = json!(["CESIUM_RTC"]);
            },
            "10,20,0 11,20,0 11,20,1 10,20,1 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "strip",
            |d, b| {
                d["meshes"][0]["primitives"][0]["mode"] = json!(5);
                b[48..60].copy_from_slice(&[0, 0, 1, 0, 3, 0, 2, 0, 2, 0, 2, 0]);
            },
            "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 1, 3], [1, 2, 3]]",
        ),
        (
            "fan",
            |d, _| {
                d["meshes"][0]["primitives"][0]["mode"] = json!(6);
                d["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
            },
            "0,0,0 1,0,0 1,0,1 0,0,1 [[1, 2, 0], [2, 3, 0]]",
        ),
        (
            "no indices",
            |d, _| {
                d["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("indices");
            },
            "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 1, 2]]",
        ),
        (
            "byte indices",
            |d, b| {
                d["accessors"][1]["componentType"] = json!(5121);
                b[48..54].copy_from_slice(&[0, 1, 2, 0, 2, 3]);
            },
            UPRIGHT,
        ),
        (
            "wide indices",
            |d, b| {
                d["accessors"][1]["componentType"] = json!(5125);
                d["bufferViews"][1]["byteLength"] = json!(24);
                d["buffers"][0]["byteLength"] = json!(72);
                b.truncate(48);
                b.extend(SQUARE_INDICES.iter().flat_map(|v| u32::from(*v).to_le_bytes()));
            },
            UPRIGHT,
        ),
        (
            "stride",
            |d, b| {
                let positions: Vec<u8> = b[..48].chunks(12).flat_map(|p| [p, &[9; 8]].concat()).collect();
                let indices = b[48..].to_vec();
                *b = [positions, indices].concat();
                d["bufferViews"] = json!([{ "buffer": 0, "byteLength": 80, "byteStride": 20 }, { "buffer": 0, "byteOffset": 80, "byteLength": 12 }]);
                d["buffers"][0]["byteLength"] = json!(92);
            },
            UPRIGHT,
        ),
        (
            "sparse",
            |d, b| {
                b.extend([2, 0, 0, 0]);
                b.extend([7.0_f32, 8.0, 9.0].iter().flat_map(|v| v.to_le_bytes()));
                d["buffers"][0]["byteLength"] = json!(76);
                d["bufferViews"].as_array_mut().unwrap().extend([
                    json!({ "buffer": 0, "byteOffset": 60, "byteLength": 1 }),
                    json!({ "buffer": 0, "byteOffset": 64, "byteLength": 12 }),
                ]);
                d["accessors"][0]["sparse"] = json!({ "count": 1, "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 3 } });
            },
            "0,0,0 1,0,0 7,-9,8 0,0,1 [[0, 1, 2], [0, 2, 3]]",
        ),
        (
            "two nodes, one mesh",
            |d, _| {
                d["nodes"] = json!([{ "mesh": 0, "children": [1] }, { "mesh": 0, "translation": [0, 1, 0] }]);
            },
            "0,0,0 1,0,0 1,0,1 0,0,1 0,0,1 1,0,1 1,0,2 0,0,2 [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]",
        ),
        (
            "two primitives share positions",
            |d, _| {
                let p = d["meshes"][0]["primitives"][0].clone();
                d["meshes"][0]["primitives"].as_array_mut().unwrap().push(p);
            },
            "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]]",
        ),
    ];
    for (name, change, expected) in cases {
        let case = Case::new(&square_with(change));
        let tile = case.read().unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(mesh_text(&tile), expected, "{name}");
        let header = read_header(&case.input(), TileFormat::Glb).expect("header");
        assert_eq!(header.vertices, tile.mesh.positions.len() as u64, "{name}: vertices of the header");
        assert!(header.triangles >= tile.mesh.triangles.len() as u64, "{name}: triangles of the header");
    }
}

#[test]
fn quantised_positions_are_decoded() {
    let cases: [(u64, bool, &[u8], f64); 6] = [
        (5123, false, &[0xFF, 0xFF], 65535.0),
        (5123, true, &[0xFF, 0xFF], 1.0),
        (5122, false, &[0x00, 0x80], -32768.0),
        (5122, true, &[0x00, 0x80], -1.0),
        (5121, true, &[51], f64::from(51.0_f32 / 255.0)),
        (5120, false, &[0x80], -128.0),
    ];
    for (component, normalized, x, expected) in cases {
        let file = square_with(|d, b| {
            b[..48].fill(0);
            for k in 0..4 {
                b[k * 12..k * 12 + x.len()].copy_from_slice(x);
            }
            d["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            d["bufferViews"][0]["byteStride"] = json!(12);
            d["accessors"][0]["componentType"] = json!(component);
            d["accessors"][0]["normalized"] = json!(normalized);
        });
        let tile = read_bytes(&file).expect("read");
        assert_eq!(tile.mesh.positions[3].x, expected, "component {component}, normalized {normalized}");
    }
}

#[test]
fn the_up_axis_option_wins() {
    let case = Case::new(&square_with(|d, _| d["asset"]["gltfUpAxis"] = json!("Y")));
    let options = ReadOptions { up_axis: Some(UpAxis::Z), ..ReadOptions::default() };
    let tile = read_tile(&case.input(), TileFormat::Glb, &options).expect("read");
    assert_eq!(tile.mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn what_is_no_triangle_passes_with_a_warning() {
    for mode in [0, 1, 2, 3] {
        let file = square_with(|d, _| d["meshes"][0]["primitives"][0]["mode"] = json!(mode));
        let tile = read_bytes(&file).expect("read");
        assert!(tile.mesh.triangles.is_empty());
        assert_eq!(tile.warnings.len(), 2, "{:?}", tile.warnings);
    }
    let nan = square_with(|_, b| b[12..16].copy_from_slice(&f32::NAN.to_le_bytes()));
    let tile = read_bytes(&nan).expect("read");
    assert_eq!((tile.mesh.positions.len(), tile.mesh.triangles.len()), (4, 1));
    assert!(tile.warnings[0].contains("not finite"), "{:?}", tile.warnings);
}

#[test]
fn buffers_outside_the_bin_chunk_are_read() {
    let (mut document, bin) = square();
    document["buffers"][0]["uri"] = json!("geometry%201.bin");
    let case = Case::new(&glb(&document.to_string(), None));
    assert!(case.read().is_err(), "the file is absent");
    fs::write(case.folder.path().join("geometry 1.bin"), &bin).expect("write");
    assert_eq!(mesh_text(&case.read().expect("read")), UPRIGHT);
    fs::write(case.folder.path().join("geometry 1.bin"), &bin[..59]).expect("write");
    assert!(case.read().expect_err("too short").to_string().contains("59 bytes"));
}

#[test]
fn textures_are_named_and_never_opened() {
    let file = square_with(|d, _| {
        d["images"] = json!([{ "uri": "../../etc/passwd" }, { "uri": "data:image/png;base64,AA==" }, { "bufferView": 0 }]);
    });
    assert_eq!(read_bytes(&file).expect("read").textures, ["../../etc/passwd"]);
}

#[test]
fn nested_transforms_compose_in_f64() {
    let file = square_with(|d, _| {
        d["scenes"][0]["nodes"] = json!([1]);
        d["nodes"] = json!([
            { "mesh": 0, "translation": [-4_000_000.25, 0, 0] },
            { "children": [0], "translation": [4_000_000.5, 0, 0], "rotation": [0, 0, 0, 1] },
        ]);
    });
    assert_eq!(read_bytes(&file).expect("read").mesh.positions[0], DVec3::new(0.25, 0.0, 0.0));
    let frame = read_bytes(&file).expect("read").frame;
    assert_eq!(frame.to_scene, UpAxis::Y.to_scene() * DAffine3::from_translation(DVec3::new(0.25, 0.0, 0.0)));
}
