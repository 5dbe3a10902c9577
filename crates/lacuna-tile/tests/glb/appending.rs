//! Patches in, originals untouched.

use crate::support::*;
use glam::{DQuat, DVec3};
use lacuna_tile::{AppendRequest, HolePatch, ReadOptions, TileError, TileFormat, append_patches};
use serde_json::{Value, json};
use std::fs;

#[test]
fn patches_join_their_rim_under_any_transform() {
    type Change = fn(&mut Value, &mut Vec<u8>);
    let cases: [(&str, Change); 12] = [
        ("plain", |_, _| {}),
        ("z up", |d, _| d["asset"]["gltfUpAxis"] = json!("Z")),
        ("x up", |d, _| d["asset"]["gltfUpAxis"] = json!("X")),
        ("far translation", |d, _| d["nodes"][0]["translation"] = json!([4_000_000.1, -2.5e6, 33.3])),
        ("scale", |d, _| d["nodes"][0]["scale"] = json!([0.25, 0.5, 2])),
        ("mirror", |d, _| d["nodes"][0]["scale"] = json!([1, -1, 1])),
        ("RTC", |d, _| d["extensions"] = json!({ "CESIUM_RTC": { "center": [529_000, 5_020_000, 0] } })),
        ("quantised", |d, b| {
            let corners = [[0_u16, 0, 0, 0], [65535, 0, 0, 0], [65535, 65535, 0, 0], [0, 65535, 0, 0]];
            b[..32].copy_from_slice(
                &corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>(),
            );
            d["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            d["bufferViews"][0]["byteStride"] = json!(8);
            d["accessors"][0]["componentType"] = json!(5123);
            d["nodes"][0]["scale"] = json!([0.0625, 0.0625, 0.0625]);
        }),
        ("two nodes, one mesh", |d, _| {
            d["scenes"][0]["nodes"] = json!([0, 1]);
            d["nodes"] = json!([{ "mesh": 0, "translation": [5.5, 6.5, 0.1] }, { "mesh": 0 }]);
        }),
        ("no scenes", |d, _| {
            d.as_object_mut().unwrap().remove("scene");
            d.as_object_mut().unwrap().remove("scenes");
        }),
        ("second BIN-less buffer", |d, _| {
            d["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 3, "uri": "data:;base64,AAAA" }));
        }),
        ("morph targets", |d, _| d["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }])),
    ];
    for (name, change) in cases {
        check_append(name, &square_with(change));
    }
}

#[test]
fn a_rotated_node_keeps_the_rim_bit_for_bit() {
    let q = DQuat::from_xyzw(0.1, 0.2, 0.3, 0.9).normalize();
    let file = square_with(|d, _| {
        d["nodes"][0]["rotation"] = json!(q.to_array());
        d["nodes"][0]["translation"] = json!([1000.5, -20.25, 7.0]);
    });
    let case = Case::new(&file);
    let before = case.read().expect("read");
    let [a, b] = [2, 1].map(|v| before.mesh.positions[v]);
    let new = before.frame.round(a + DVec3::new(1.0, 2.0, 3.0));
    case.append(&[patch([2, 1], new)]).expect("append");
    let after = case.read_output();
    check_originals("rotated", &before, &after);
    let corners = after.mesh.corners(2);
    assert_eq!([corners[0], corners[1]], [a, b], "rim copies are exact");
    assert!((corners[2] - new).length() < 1e-9, "{} away", (corners[2] - new).length());
}

#[test]
fn the_json_and_the_bytes_that_were_there_stay() {
    let document = r#"{ "asset":{"version":"2.0","x":1.50}, "zzz":[1e3, {"a":0.10}],
        "scene":0,"scenes":[{"nodes":[0],"name":"s"}],"nodes":[{"mesh":0,"extras":2.0}],
        "meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0},"indices":1,"extras":{"k":1.0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0.0,0.0,0.0],"max":[1.0,1.0,0.0]},
        {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60,"name":"b"}],"extensionsUsed":["FOO_bar"],"aaa":{"big":123456789012345678901234567890}}"#;
    let mut file = glb(document, Some(&square().1));
    push_chunk(&mut file, b"XTRA", b"of another program", 0);
    set_length(&mut file);
    let (case, _) = check_append("own text", &file);
    let output = fs::read(case.output()).expect("output");
    let length = u32::from_le_bytes(output[12..16].try_into().expect("four")) as usize;
    let text = std::str::from_utf8(&output[20..20 + length]).expect("UTF-8");
    for kept in [
        r#""asset":{"version":"2.0","x":1.50}"#,
        r#""zzz":[1e3, {"a":0.10}]"#,
        r#""extras":{"k":1.0}"#,
        r#"{"mesh":0,"extras":2.0}"#,
        r#""max":[1.0,1.0,0.0]"#,
        r#""name":"b""#,
        r#""aaa":{"big":123456789012345678901234567890}"#,
    ] {
        assert!(text.contains(kept), "{kept} is missing in {text}");
    }
    assert!(text.find("\"zzz\"") < text.find("\"aaa\""), "order as written");
    assert_eq!(bin_of(&output)[..60], square().1[..], "BIN begins as it was");
    assert!(output.ends_with(&file[file.len() - 28..]), "chunks of others follow");
}

#[test]
fn the_patch_primitive_is_complete() {
    let file = square_with(|d, b| {
        let colours: [u8; 16] = [10, 20, 30, 255, 100, 110, 120, 255, 50, 60, 70, 255, 0, 0, 0, 255];
        b.extend(colours);
        d["buffers"][0]["byteLength"] = json!(76);
        d["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 0, "byteOffset": 60, "byteLength": 16 }));
        d["accessors"].as_array_mut().unwrap().push(json!({
            "bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4",
        }));
        d["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
        d["extensionsUsed"] = json!(["KHR_materials_unlit"]);
        d["materials"] = json!([{ "name": "old" }]);
    });
    let (case, _) = check_append("coloured", &file);
    let output = fs::read(case.output()).expect("output");
    let (json, bin) = (json_of(&output), bin_of(&output));
    let primitive = &json["meshes"][0]["primitives"][1];
    assert_eq!(
        primitive["extras"]["lacuna"],
        json!({ "hole": "h \"1\"", "cluster": "0_0", "class": "I", "shape": "B", "method": "layered", "area_m2": 0.5 })
    );
    assert_eq!(json["materials"][1]["name"], "lacuna_patch");
    assert_eq!(json["materials"][1]["extensions"], json!({ "KHR_materials_unlit": {} }));
    assert_eq!((&primitive["material"], &primitive["mode"]), (&json!(1), &json!(4)));
    let bytes = |attribute: &str| {
        let accessor = &json["accessors"][primitive["attributes"][attribute].as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        assert_eq!(start % 4, 0, "{attribute} is aligned");
        (accessor.clone(), bin[start..start + view["byteLength"].as_u64().unwrap() as usize].to_vec())
    };
    let (colour, values) = bytes("COLOR_0");
    assert_eq!((&colour["componentType"], &colour["normalized"]), (&json!(5121), &json!(true)));
    assert_eq!(values, [100, 110, 120, 255, 50, 60, 70, 255, 75, 85, 95, 255]);
    let (_, normals) = bytes("NORMAL");
    for normal in normals.chunks(12) {
        let n: Vec<f32> = normal.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert!((n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-5, "{n:?} is a unit vector");
    }
    let (position, stored) = bytes("POSITION");
    for axis in 0..3 {
        let values =
            stored.chunks(12).map(|p| f32::from_le_bytes(p[axis * 4..axis * 4 + 4].try_into().unwrap()));
        let (min, max) = values.fold((f32::MAX, f32::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
        assert_eq!(position["min"][axis].as_f64().unwrap() as f32, min);
        assert_eq!(position["max"][axis].as_f64().unwrap() as f32, max);
    }
    let length = json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
    assert_eq!(length.next_multiple_of(4), bin.len(), "the buffer is the chunk without its padding");
}

#[test]
fn the_float_forms_of_colour_stay_floats() {
    let file = square_with(|d, b| {
        b.extend([0.25_f32, 0.5, 0.75].repeat(4).iter().flat_map(|v| v.to_le_bytes()));
        d["buffers"][0]["byteLength"] = json!(108);
        d["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 0, "byteOffset": 60, "byteLength": 48 }));
        d["accessors"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3" }));
        d["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
    });
    let (case, _) = check_append("coloured", &file);
    let output = fs::read(case.output()).expect("output");
    let json = json_of(&output);
    let colour = json["meshes"][0]["primitives"][1]["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    assert_eq!(json["accessors"][colour]["componentType"], 5126);
    let expected: Vec<u8> =
        [0.25_f32, 0.5, 0.75, 1.0].repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect();
    assert!(bin_of(&output).windows(48).any(|w| w == expected));
}

#[test]
fn bytes_go_into_a_data_buffer_where_buffer_0_is_outside() {
    let (mut document, bin) = square();
    document["buffers"][0]["uri"] = json!("g.bin");
    let case = Case::new(&glb(&document.to_string(), None));
    fs::write(case.folder.path().join("g.bin"), &bin).expect("write");
    let before = case.read().expect("read");
    case.append(&[patch([2, 1], DVec3::new(2.0, 0.0, 0.5))]).expect("append");
    let after = case.read_output();
    check_originals("external", &before, &after);
    assert_eq!(after.mesh.corners(2)[2], DVec3::new(2.0, 0.0, 0.5));
    assert_eq!(fs::read(case.folder.path().join("g.bin")).expect("read"), bin, "the side file is untouched");
}

#[test]
fn many_patches_and_patches_without_a_rim_are_written() {
    let file = square_with(|d, _| d["nodes"][0]["translation"] = json!([100.5, 0, 0]));
    let case = Case::new(&file);
    let before = case.read().expect("read");
    let corner = |x: f64, y: f64| before.frame.round(DVec3::new(x, y, 0.25));
    let square: Vec<DVec3> =
        vec![corner(103.0, 0.1), corner(104.0, 0.1), corner(104.0, 1.1), corner(103.0, 1.1)];
    let empty = HolePatch { triangles: Vec::new(), ..patch([0, 1], DVec3::ZERO) };
    let patches = [
        patch([2, 1], corner(102.0, 0.0)),
        free_patch(square.clone()),
        empty,
        patch([1, 0], corner(101.0, 2.0)),
        free_patch(square),
    ];
    case.append(&patches).expect("append");
    let after = case.read_output();
    assert_eq!(after.mesh.triangles.len(), 2 + 1 + 2 + 1 + 2);
    let json = json_of(&fs::read(case.output()).expect("output"));
    assert_eq!(json["meshes"][0]["primitives"].as_array().map(Vec::len), Some(3));
    assert_eq!(
        json["meshes"][1]["primitives"].as_array().map(Vec::len),
        Some(2),
        "one mesh for all free patches"
    );
    assert_eq!(json["scenes"][0]["nodes"], json!([0, 1]));
    assert_eq!(after.mesh.corners(4)[0], corner(103.0, 0.1));
}

#[test]
fn from_65535_vertices_on_indices_are_wide() {
    for (vertices, component) in [(65_534, 5123), (65_535, 5125)] {
        let case = Case::new(&square_with(|_, _| {}));
        let vertex = |k: u32| DVec3::new(f64::from(k % 256), f64::from(k / 256), 0.0);
        case.append(&[free_patch((0..vertices).map(vertex).collect())]).expect("append");
        let json = json_of(&fs::read(case.output()).expect("output"));
        let indices = json["meshes"][1]["primitives"][0]["indices"].as_u64().unwrap() as usize;
        assert_eq!(json["accessors"][indices]["componentType"], component);
        let after = case.read_output();
        assert_eq!(after.mesh.corners(after.mesh.triangles.len() - 1)[2], vertex(vertices - 1));
    }
}

#[test]
fn appending_to_what_was_appended_to_works() {
    let (case, added) = check_append("once", &square_with(|_, _| {}));
    let again = Case::new(&fs::read(case.output()).expect("output"));
    let before = again.read().expect("read");
    again.append(&[patch([4, 0], DVec3::new(3.0, 3.0, 3.0)), added]).expect("append");
    check_originals("twice", &before, &again.read_output());
}

#[test]
fn nothing_to_append_is_the_same_bytes() {
    let file = square_with(|_, _| {});
    let case = Case::new(&file);
    case.append(&[]).expect("append");
    assert_eq!(fs::read(case.output()).expect("output"), file);
}

#[test]
fn what_does_not_fit_is_refused_and_leaves_no_file() {
    let case = Case::new(&square_with(|_, _| {}));
    let nan = patch([0, 1], DVec3::new(f64::NAN, 0.0, 0.0));
    for bad in [patch([0, 4], DVec3::ONE), nan] {
        assert!(matches!(case.append(&[bad]), Err(TileError::BadPatch { .. })));
    }
    let hash = Some([1; 32]);
    let request = AppendRequest {
        input: &case.input(),
        output: &case.output(),
        format: TileFormat::Glb,
        options: &ReadOptions::default(),
        expected_hash: hash,
        patches: &[],
    };
    assert!(matches!(append_patches(&request), Err(TileError::InputChanged { .. })));
    let flat = Case::new(&square_with(|d, _| d["nodes"][0]["scale"] = json!([1, 0, 1])));
    assert!(flat.append(&[patch([0, 1], DVec3::ONE)]).expect_err("flat").to_string().contains("inverted"));
    for case in [&case, &flat] {
        assert_eq!(fs::read_dir(case.folder.path()).expect("folder").count(), 1);
    }
}
