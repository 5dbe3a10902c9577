//! GLB tiles: dialects, frames, appending, hostile files, real files.

#![allow(clippy::print_stderr, reason = "a test that skips says so")]

use glam::{DAffine3, DQuat, DVec3};
use lacuna_mesh::VertexId;
use lacuna_tile::{
    AppendRequest, Corner, HolePatch, NewTileRequest, ReadOptions, ReadTile, TileError, TileFormat, UpAxis,
    Written, append_patches, new_tile, read_header, read_tile,
};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// A square of two triangles in the x-y plane of the file.
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const SQUARE_INDICES: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A document with the square: accessor 0 positions, accessor 1 indices; bytes 0..48 and 48..60.
fn square() -> (Value, Vec<u8>) {
    let mut bin: Vec<u8> = SQUARE.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bin.extend(SQUARE_INDICES.iter().flat_map(|v| v.to_le_bytes()));
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": bin.len() }],
    });
    (document, bin)
}

/// The square's document, changed.
fn square_with(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut document, mut bin) = square();
    change(&mut document, &mut bin);
    glb(&document.to_string(), Some(&bin))
}

/// A GLB file from its parts.
fn glb(json: &str, bin: Option<&[u8]>) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    push_chunk(&mut file, b"JSON", json.as_bytes(), b' ');
    if let Some(bin) = bin {
        push_chunk(&mut file, b"BIN\0", bin, 0);
    }
    set_length(&mut file);
    file
}

fn push_chunk(file: &mut Vec<u8>, kind: &[u8; 4], content: &[u8], padding: u8) {
    let length = content.len().next_multiple_of(4);
    file.extend((length as u32).to_le_bytes());
    file.extend(kind);
    file.extend(content);
    file.extend(std::iter::repeat_n(padding, length - content.len()));
}

fn set_length(file: &mut [u8]) {
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
}

/// A file in a folder of its own.
struct Case {
    folder: tempfile::TempDir,
}

impl Case {
    fn new(file: &[u8]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        fs::write(folder.path().join("in.glb"), file).expect("write");
        Self { folder }
    }

    fn input(&self) -> PathBuf {
        self.folder.path().join("in.glb")
    }

    fn output(&self) -> PathBuf {
        self.folder.path().join("out.glb")
    }

    fn read(&self) -> Result<ReadTile, TileError> {
        read_tile(&self.input(), TileFormat::Glb, &ReadOptions::default())
    }

    fn append(&self, patches: &[HolePatch]) -> Result<Written, TileError> {
        append_patches(&AppendRequest {
            input: &self.input(),
            output: &self.output(),
            format: TileFormat::Glb,
            options: &ReadOptions::default(),
            expected_hash: None,
            patches,
        })
    }

    fn read_output(&self) -> ReadTile {
        read_tile(&self.output(), TileFormat::Glb, &ReadOptions::default()).expect("the output reads")
    }
}

fn read_bytes(file: &[u8]) -> Result<ReadTile, TileError> {
    Case::new(file).read()
}

/// Positions and triangles on one line.
fn mesh_text(tile: &ReadTile) -> String {
    let positions: Vec<String> =
        tile.mesh.positions.iter().map(|p| format!("{},{},{}", p.x + 0.0, p.y + 0.0, p.z + 0.0)).collect();
    format!("{} {:?}", positions.join(" "), tile.mesh.triangles)
}

/// A patch of one triangle from two vertices of the tile and one new one.
fn patch(corners: [u32; 2], new: DVec3) -> HolePatch {
    HolePatch {
        hole: "h \"1\"".into(),
        cluster: "0_0".into(),
        class: "I".into(),
        shape: Some("B".into()),
        method: "layered".into(),
        filler: "delaunay".into(),
        area_m2: 0.5,
        vertices: vec![new],
        triangles: vec![[
            Corner::Original(VertexId(corners[0])),
            Corner::Original(VertexId(corners[1])),
            Corner::New(0),
        ]],
    }
}

/// A patch without a rim.
fn free_patch(vertices: Vec<DVec3>) -> HolePatch {
    let triangles = (2..vertices.len() as u32).map(|k| [0, k - 1, k].map(Corner::New)).collect();
    HolePatch { vertices, triangles, ..patch([0, 1], DVec3::ZERO) }
}

fn json_of(file: &[u8]) -> Value {
    let length = u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&file[20..20 + length]).expect("JSON")
}

fn bin_of(file: &[u8]) -> &[u8] {
    let json = u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    let start = 20 + json;
    let length = u32::from_le_bytes(file[start..start + 4].try_into().expect("four bytes")) as usize;
    &file[start + 8..start + 8 + length]
}

// --- reading -----------------------------------------------------------------------------------------------------------

const UPRIGHT: &str = "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 1, 2], [0, 2, 3]]";

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

// --- refusals ----------------------------------------------------------------------------------------------------------

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
    let error = read_bytes(&glb(&document.to_string(), Some(&bin))).expect_err("refused");
    assert!(error.to_string().contains("proportion"), "{error}");
}

// --- appending ---------------------------------------------------------------------------------------------------------

/// Appends a patch on vertices 1 and 2 of `file` with a third corner near them; checks what every append must keep.
fn check_append(name: &str, file: &[u8]) -> (Case, HolePatch) {
    let case = Case::new(file);
    let before = case.read().unwrap_or_else(|e| panic!("{name}: {e}"));
    let [a, b] = [2, 1].map(|v| before.mesh.positions[v]);
    let new = before.frame.round((a + b) / 2.0 + DVec3::new(1.1, 0.3, 0.7));
    let added = patch([2, 1], new);
    let written = case.append(std::slice::from_ref(&added)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let output = fs::read(case.output()).expect("output");
    assert_eq!(written.bytes, output.len() as u64, "{name}");
    assert_eq!(&written.hash, blake3::hash(&output).as_bytes(), "{name}");
    let after = case.read_output();
    let (n, t) = (before.mesh.positions.len(), before.mesh.triangles.len());
    assert_eq!(after.mesh.triangles.len(), t + 1, "{name}");
    check_originals(name, &before, &after);
    let found = after.mesh.triangles.iter().map(|tri| tri.map(|v| after.mesh.positions[v as usize]));
    let expected = [a, b, new];
    let is_patch = |tri: &[DVec3; 3]| (0..3).any(|turn| (0..3).all(|k| tri[(k + turn) % 3] == expected[k]));
    assert_eq!(
        found.filter(is_patch).count(),
        1,
        "{name}: the patch reads back bit for bit, the same way round"
    );
    assert_eq!(after.mesh.positions.len(), n + 3, "{name}");
    (case, added)
}

/// All triangles of `before` are in `after`, in the same order, with the same corners.
fn check_originals(name: &str, before: &ReadTile, after: &ReadTile) {
    let corners = |tile: &ReadTile, at: usize| tile.mesh.corners(at).map(|p| p.to_array().map(f64::to_bits));
    let mut next = 0;
    for at in 0..after.mesh.triangles.len() {
        if next < before.mesh.triangles.len() && corners(after, at) == corners(before, next) {
            next += 1;
        }
    }
    assert_eq!(next, before.mesh.triangles.len(), "{name}: originals in order");
}

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

// --- real files --------------------------------------------------------------------------------------------------------

fn shared_data(path: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(path);
    if !found.exists() {
        eprintln!("skipped: ../shared/data/{path} is absent");
        return None;
    }
    Some(found)
}

/// The GLB inside a b3dm file: its header names the sizes of the tables before it.
fn glb_of_b3dm(file: &[u8]) -> Vec<u8> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().expect("four bytes")) as usize;
    let start = 28 + number(12) + number(16) + number(20) + number(24);
    file[start..].to_vec()
}

#[test]
fn real_tiles_read_or_are_refused_by_name() {
    let Some(folder) = shared_data("loadersgl-tiles") else { return };
    let cases = [
        ("frankfurt_474_5548_lv5_osgb3.b3dm", Err("Draco (KHR_draco_mesh_compression)")),
        ("helsinki_points_meshopt_0.glb", Err("meshopt (EXT_meshopt_compression)")),
        ("realitycapture_trianglestrip_lod1_0.b3dm", Ok(10_338)),
        ("vricon_muscatatuck_0_0_0.glb", Ok(91)),
        ("ferry_0000000.glb", Ok(36_334)),
    ];
    for (name, expected) in cases {
        let mut file = fs::read(folder.join(name)).expect("read");
        if name.ends_with(".b3dm") {
            file = glb_of_b3dm(&file);
        }
        match (read_bytes(&file), expected) {
            (Ok(tile), Ok(vertices)) => {
                assert_eq!(tile.mesh.positions.len(), vertices, "{name}");
                assert!(tile.mesh.triangles.len() > 50, "{name}");
                check_append(name, &file);
            }
            (Err(error), Err(word)) => assert!(error.to_string().contains(word), "{name}: {error}"),
            (result, _) => panic!("{name}: {:?}", result.map(|tile| tile.mesh.positions.len())),
        }
    }
}

#[test]
fn real_strips_become_a_closed_surface_that_looks_outwards() {
    let Some(folder) = shared_data("loadersgl-tiles") else { return };
    let file = fs::read(folder.join("realitycapture_trianglestrip_lod1_0.b3dm")).expect("read");
    let tile = read_bytes(&glb_of_b3dm(&file)).expect("read");
    let (mut area, mut total, mut volume) = (DVec3::ZERO, 0.0, 0.0);
    for t in 0..tile.mesh.triangles.len() {
        let [a, b, c] = tile.mesh.corners(t);
        let normal = (b - a).cross(c - a) / 2.0;
        area += normal;
        total += normal.length();
        volume += a.dot(normal) / 3.0;
    }
    // A strip whose winding did not alternate would leave half of its area uncancelled.
    assert!(area.length() < 1e-5 * total, "area vectors cancel: {area} of {total} m2");
    assert!(volume > 0.0, "outwards: {volume} m3");
}

/// Every GLB below a folder, sorted.
fn glb_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).expect("folder").flatten().map(|e| e.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            glb_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "glb") {
            found.push(path);
        }
    }
}

#[test]
fn validator_files_read_or_are_refused() {
    let Some(folder) = shared_data("gltf-validator-files") else { return };
    let mut files = Vec::new();
    glb_files(&folder, &mut files);
    assert!(files.len() >= 37, "{} GLB files", files.len());
    for path in &files {
        let whole = read_tile(path, TileFormat::Glb, &ReadOptions::default());
        if let Err(error) = &whole {
            assert!(!error.to_string().is_empty());
            assert!(matches!(error, TileError::Malformed { .. } | TileError::Unsupported { .. }), "{error}");
        }
        let _ = read_header(path, TileFormat::Glb);
    }
}

#[test]
fn validator_documents_read_or_are_refused() {
    let Some(folder) = shared_data("gltf-validator-files") else { return };
    let mut waiting = vec![folder];
    let mut count = 0;
    while let Some(folder) = waiting.pop() {
        for path in fs::read_dir(folder).expect("folder").flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf") {
                let text = fs::read(&path).expect("read");
                let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
                push_chunk(&mut file, b"JSON", &text, b' ');
                set_length(&mut file);
                let case = Case::new(&file);
                if let Ok(tile) = case.read() {
                    let _ = case.append(&[free_patch(vec![DVec3::ZERO, DVec3::X, DVec3::Y])]);
                    assert!(
                        tile.mesh
                            .triangles
                            .iter()
                            .flatten()
                            .all(|&v| (v as usize) < tile.mesh.positions.len())
                    );
                }
                count += 1;
            }
        }
    }
    assert!(count > 200, "{count} documents");
}
