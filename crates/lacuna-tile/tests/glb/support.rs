//! Small GLB files made in the test, and what every append must keep.

use glam::DVec3;
use lacuna_mesh::VertexId;
use lacuna_tile::{
    AppendRequest, Corner, HolePatch, ReadOptions, ReadTile, TileError, TileFormat, Written, append_patches,
    read_tile,
};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

/// A square of two triangles in the x-y plane of the file.
pub(crate) const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
pub(crate) const SQUARE_INDICES: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A document with the square: accessor 0 positions, accessor 1 indices; bytes 0..48 and 48..60.
pub(crate) fn square() -> (Value, Vec<u8>) {
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
pub(crate) fn square_with(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> Vec<u8> {
    let (mut document, mut bin) = square();
    change(&mut document, &mut bin);
    glb(&document.to_string(), Some(&bin))
}

/// A GLB file from its parts.
pub(crate) fn glb(json: &str, bin: Option<&[u8]>) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    push_chunk(&mut file, b"JSON", json.as_bytes(), b' ');
    if let Some(bin) = bin {
        push_chunk(&mut file, b"BIN\0", bin, 0);
    }
    set_length(&mut file);
    file
}

pub(crate) fn push_chunk(file: &mut Vec<u8>, kind: &[u8; 4], content: &[u8], padding: u8) {
    let length = content.len().next_multiple_of(4);
    file.extend((length as u32).to_le_bytes());
    file.extend(kind);
    file.extend(content);
    file.extend(std::iter::repeat_n(padding, length - content.len()));
}

pub(crate) fn set_length(file: &mut [u8]) {
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
}

/// A file in a folder of its own.
pub(crate) struct Case {
    pub(crate) folder: tempfile::TempDir,
}

impl Case {
    pub(crate) fn new(file: &[u8]) -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        fs::write(folder.path().join("in.glb"), file).expect("write");
        Self { folder }
    }

    pub(crate) fn input(&self) -> PathBuf {
        self.folder.path().join("in.glb")
    }

    pub(crate) fn output(&self) -> PathBuf {
        self.folder.path().join("out.glb")
    }

    pub(crate) fn read(&self) -> Result<ReadTile, TileError> {
        read_tile(&self.input(), TileFormat::Glb, &ReadOptions::default())
    }

    pub(crate) fn append(&self, patches: &[HolePatch]) -> Result<Written, TileError> {
        append_patches(&AppendRequest {
            input: &self.input(),
            output: &self.output(),
            format: TileFormat::Glb,
            options: &ReadOptions::default(),
            expected_hash: None,
            patches,
        })
    }

    pub(crate) fn read_output(&self) -> ReadTile {
        read_tile(&self.output(), TileFormat::Glb, &ReadOptions::default()).expect("the output reads")
    }
}

pub(crate) fn read_bytes(file: &[u8]) -> Result<ReadTile, TileError> {
    Case::new(file).read()
}

/// Positions and triangles on one line.
pub(crate) fn mesh_text(tile: &ReadTile) -> String {
    let positions: Vec<String> =
        tile.mesh.positions.iter().map(|p| format!("{},{},{}", p.x + 0.0, p.y + 0.0, p.z + 0.0)).collect();
    format!("{} {:?}", positions.join(" "), tile.mesh.triangles)
}

/// A patch of one triangle from two vertices of the tile and one new one.
pub(crate) fn patch(corners: [u32; 2], new: DVec3) -> HolePatch {
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
pub(crate) fn free_patch(vertices: Vec<DVec3>) -> HolePatch {
    let triangles = (2..vertices.len() as u32).map(|k| [0, k - 1, k].map(Corner::New)).collect();
    HolePatch { vertices, triangles, ..patch([0, 1], DVec3::ZERO) }
}

pub(crate) fn json_of(file: &[u8]) -> Value {
    let length = u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&file[20..20 + length]).expect("JSON")
}

pub(crate) fn bin_of(file: &[u8]) -> &[u8] {
    let json = u32::from_le_bytes(file[12..16].try_into().expect("four bytes")) as usize;
    let start = 20 + json;
    let length = u32::from_le_bytes(file[start..start + 4].try_into().expect("four bytes")) as usize;
    &file[start + 8..start + 8 + length]
}

pub(crate) const UPRIGHT: &str = "0,0,0 1,0,0 1,0,1 0,0,1 [[0, 1, 2], [0, 2, 3]]";

/// Appends a patch on vertices 1 and 2 of `file` with a third corner near them; checks what every append must keep.
pub(crate) fn check_append(name: &str, file: &[u8]) -> (Case, HolePatch) {
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
pub(crate) fn check_originals(name: &str, before: &ReadTile, after: &ReadTile) {
    let corners = |tile: &ReadTile, at: usize| tile.mesh.corners(at).map(|p| p.to_array().map(f64::to_bits));
    let mut next = 0;
    for at in 0..after.mesh.triangles.len() {
        if next < before.mesh.triangles.len() && corners(after, at) == corners(before, next) {
            next += 1;
        }
    }
    assert_eq!(next, before.mesh.triangles.len(), "{name}: originals in order");
}
