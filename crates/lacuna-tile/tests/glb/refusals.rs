//! Hostile and damaged files end in typed errors.

use crate::support::*;
use lacuna_tile::{TileError, TileFormat, read_header};
use serde_json::{Value, json};
use std::fs;

#[test]
fn hostile_documents_are_typed_errors() {
    type Change = fn(&mut Value, &mut Vec<u8>);
    let cases: [(&str, Change, &str); 31] = [
        ("count 2^31", |d, _| d["accessors"][0]["count"] = json!(1_u64 << 31), "do not fit"),
        ("count 2^53", |d, _| d["accessors"][0]["count"] = json!(1_u64 << 53), "do not fit"),
        (
            "count 2^53 of zeros",
            |d, _| {
                d["accessors"][0]["count"] = json!(1_u64 << 53);
                d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            },
            "too large",
        ),
        (
            "count 2^31 of zeros",
            |d, _| {
                d["accessors"][0]["count"] = json!(1_u64 << 31);
                d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            },
            "proportion",
        ),
        ("count of indices", |d, _| d["accessors"][1]["count"] = json!(7), "do not fit"),
        ("byteOffset", |d, _| d["accessors"][0]["byteOffset"] = json!(u64::MAX - 7), "do not fit"),
        ("view offset", |d, _| d["bufferViews"][0]["byteOffset"] = json!(u64::MAX - 7), "/bufferViews/0"),
        ("view past the end", |d, _| d["bufferViews"][1]["byteLength"] = json!(13), "/bufferViews/1"),
        ("buffer past the end", |d, _| d["buffers"][0]["byteLength"] = json!(64), "/buffers/0"),
        ("stride 0", |d, _| d["bufferViews"][0]["byteStride"] = json!(0), "byteStride 0"),
        ("stride 1", |d, _| d["bufferViews"][0]["byteStride"] = json!(1), "byteStride 1"),
        ("stride 255", |d, _| d["bufferViews"][0]["byteStride"] = json!(255), "byteStride 255"),
        ("stride 256", |d, _| d["bufferViews"][0]["byteStride"] = json!(256), "byteStride 256"),
        ("index = vertex count", |_, b| b[48] = 4, "index 4, but there are 4"),
        (
            "no such accessor",
            |d, _| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(2),
            "accessor 2",
        ),
        ("no such mesh", |d, _| d["nodes"][0]["mesh"] = json!(1), "mesh 1"),
        ("no such node", |d, _| d["scenes"][0]["nodes"] = json!([9]), "node 9"),
        ("no such scene", |d, _| d["scene"] = json!(9), "scene 9"),
        ("no such buffer", |d, _| d["bufferViews"][0]["buffer"] = json!(1), "buffer 1"),
        ("mode 7", |d, _| d["meshes"][0]["primitives"][0]["mode"] = json!(7), "mode 7"),
        ("float indices", |d, _| d["accessors"][1]["componentType"] = json!(5126), "do not fit"),
        ("unknown component", |d, _| d["accessors"][0]["componentType"] = json!(5124), "componentType 5124"),
        ("matrices as positions", |d, _| d["accessors"][0]["type"] = json!("MAT4"), "MAT4"),
        ("pairs as positions", |d, _| d["accessors"][0]["type"] = json!("VEC2"), "VEC3"),
        ("node cycle", |d, _| d["nodes"][0]["children"] = json!([0]), "reached twice"),
        (
            "two parents",
            |d, _| {
                d["nodes"] = json!([{ "mesh": 0 }]);
                d["scenes"][0]["nodes"] = json!([0, 0]);
            },
            "reached twice",
        ),
        ("short matrix", |d, _| d["nodes"][0]["matrix"] = json!([1, 2]), "JSON /"),
        (
            "projective matrix",
            |d, _| d["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "last row",
        ),
        (
            "sparse out of range",
            |d, _| d["accessors"][0]["sparse"] = json!({ "count": 1, "indices": { "bufferView": 1, "byteOffset": 10, "componentType": 5123 }, "values": { "bufferView": 0 } }),
            "",
        ),
        ("negative count", |d, _| d["accessors"][0]["count"] = json!(-1), "JSON /"),
        ("up axis", |d, _| d["asset"]["gltfUpAxis"] = json!("up"), "up axis"),
    ];
    for (name, change, word) in cases {
        let file = square_with(change);
        match read_bytes(&file) {
            Err(error) => assert!(error.to_string().contains(word), "{name}: {error}"),
            Ok(_) => assert_eq!(name, "sparse out of range", "{name} is refused"),
        }
        // What a job is lent follows from these counts.
        let promised = read_header(&Case::new(&file).input(), TileFormat::Glb).map_or(0, |h| h.vertices);
        assert!(promised <= 1 << 20, "{name}: {promised} vertices promised by {} bytes", file.len());
    }
}

#[test]
fn sparse_indices_are_checked() {
    for (indices, is_good) in [([0, 3], true), ([3, 0], false), ([1, 1], false), ([0, 4], false)] {
        let file = square_with(|d, b| {
            b.extend(indices);
            b.extend([0; 2]);
            b.extend([0; 24]);
            d["buffers"][0]["byteLength"] = json!(88);
            d["bufferViews"]
                .as_array_mut()
                .unwrap()
                .push(json!({ "buffer": 0, "byteOffset": 60, "byteLength": 28 }));
            d["accessors"][0]["sparse"] = json!({
                "count": 2,
                "indices": { "bufferView": 2, "componentType": 5121 },
                "values": { "bufferView": 2, "byteOffset": 4 },
            });
        });
        assert_eq!(read_bytes(&file).is_ok(), is_good, "{indices:?}");
    }
}

#[test]
fn extensions_are_refused_by_name() {
    let cases = [
        ("KHR_draco_mesh_compression", "this build does not decode"),
        ("EXT_meshopt_compression", "this build does not decode"),
        ("KHR_techniques_webgl", "KHR_techniques_webgl"),
        ("X\u{1b}[2J", "X\\u{1b}"),
    ];
    for (name, word) in cases {
        let case = Case::new(&square_with(|d, _| d["extensionsRequired"] = json!([name])));
        let error = case.read().expect_err("refused");
        assert!(matches!(error, TileError::Unsupported { .. }), "{name}");
        assert!(error.to_string().contains(word), "{error}");
        assert!(read_header(&case.input(), TileFormat::Glb).is_err(), "{name}");
    }
    for name in ["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_transform", "EXT_texture_webp"]
    {
        assert!(read_bytes(&square_with(|d, _| d["extensionsRequired"] = json!([name]))).is_ok(), "{name}");
    }
}

#[test]
fn a_buffer_outside_the_folder_fails_the_tile() {
    let outside = tempfile::tempdir().expect("temporary folder");
    fs::write(outside.path().join("secret.bin"), square().1).expect("write");
    let absolute = outside.path().join("secret.bin");
    let up = format!("../{}/secret.bin", outside.path().file_name().unwrap().to_str().unwrap());
    let encoded = up.replace("..", "%2e%2e");
    let file_uri = format!("file://{}", absolute.display());
    for uri in [
        absolute.to_str().unwrap(),
        &up,
        &encoded,
        &file_uri,
        "http://127.0.0.1/x",
        "%FF%FE",
        "link.bin",
        ".",
        "pipe",
    ] {
        let case = Case::new(&square_with(|d, _| d["buffers"][0]["uri"] = json!(uri)));
        #[cfg(unix)]
        std::os::unix::fs::symlink(&absolute, case.folder.path().join("link.bin")).expect("link");
        #[cfg(unix)]
        std::os::unix::net::UnixListener::bind(case.folder.path().join("pipe")).expect("socket");
        let error = case.read().expect_err(uri);
        assert!(error.to_string().contains("/buffers/0"), "{uri}: {error}");
    }
}

#[test]
fn broken_containers_are_typed_errors() {
    let good = square_with(|_, _| {});
    let patched = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let second_bin = {
        let mut file = good.clone();
        push_chunk(&mut file, b"BIN\0", &[0; 4], 0);
        set_length(&mut file);
        file
    };
    let deep = glb(&format!("{{\"asset\":{{\"version\":\"2.0\",\"extras\":{}", "[".repeat(200_000)), None);
    let cases = [
        ("empty", Vec::new()),
        ("magic", patched(0, b"glTf")),
        ("version 1", patched(4, &[1])),
        ("version 3", patched(4, &[3])),
        ("length 0", patched(8, &[0; 4])),
        ("length 11", patched(8, &[11, 0, 0, 0])),
        ("length 2^32-1", patched(8, &[0xFF; 4])),
        ("JSON length 2^32-1", patched(12, &[0xFF; 4])),
        ("no JSON first", patched(16, b"BIN\0")),
        ("two BIN chunks", second_bin),
        ("no JSON text", glb("", None)),
        ("JSON array", glb("[]", None)),
        ("no asset", glb("{\"nodes\":[]}", None)),
        ("deep JSON", deep),
        ("repeated key", glb("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[],\"nodes\":[]}", None)),
        (
            "huge number",
            glb("{\"nodes\":[{\"translation\":[1e999,0,0]}],\"asset\":{\"version\":\"2.0\"}}", None),
        ),
        ("no BIN", glb(&square().0.to_string(), None)),
    ];
    for (name, file) in cases {
        let error = read_bytes(&file).expect_err(name);
        assert!(
            matches!(error, TileError::Malformed { .. } | TileError::Unsupported { .. }),
            "{name}: {error}"
        );
    }
}

#[test]
fn truncated_files_are_typed_errors() {
    let good = square_with(|_, _| {});
    for sixteenth in 0..16 {
        let file = &good[..good.len() * sixteenth / 16];
        assert!(read_bytes(file).is_err(), "{sixteenth}/16 of a file");
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let good = square_with(|_, _| {});
    let case = Case::new(&good);
    for at in 0..good.len() {
        for flip in [0x01, 0x80, 0xFF] {
            let mut file = good.clone();
            file[at] ^= flip;
            fs::write(case.input(), &file).expect("write");
            let _ = case.read();
            let _ = read_header(&case.input(), TileFormat::Glb);
        }
    }
}

#[test]
fn a_deep_hierarchy_is_walked() {
    let depth = 100_000;
    let nodes: Vec<Value> =
        (1..depth).map(|k| json!({ "children": [k] })).chain([json!({ "mesh": 0 })]).collect();
    let tile = read_bytes(&square_with(|d, _| d["nodes"] = json!(nodes))).expect("read");
    assert_eq!(mesh_text(&tile), UPRIGHT);
}

#[test]
fn one_mesh_placed_very_often_is_refused() {
    let (mut document, _) = square();
    document["nodes"] = json!(vec![json!({ "mesh": 0 }); 20_000]);
    document["scenes"] = json!([{ "nodes": (0..20_000).collect::<Vec<u32>>() }]);
    document["accessors"][0]["count"] = json!(4096);
    document["accessors"][0]["byteOffset"] = json!(0);
    let bin = vec![0; 4096 * 12 + 12];
    document["buffers"][0]["byteLength"] = json!(bin.len());
    document["bufferViews"][0]["byteLength"] = json!(4096 * 12);
    document["bufferViews"][1]["byteOffset"] = json!(4096 * 12);
    let case = Case::new(&glb(&document.to_string(), Some(&bin)));
    let header = read_header(&case.input(), TileFormat::Glb).map(|_| ());
    for result in [case.read().map(|_| ()), header] {
        let error = result.expect_err("refused");
        assert!(error.to_string().contains("proportion"), "{error}");
    }
}
