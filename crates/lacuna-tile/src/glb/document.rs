//! The parts of a glTF document that geometry hangs on. Everything else stays text.

use super::json_fault;
use crate::error::Place;
use crate::fault::Fault;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;

/// A glTF document, as far as geometry needs it. Indices are as written, not yet checked.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Document {
    pub(super) asset: Asset,
    pub(super) scene: Option<u64>,
    pub(super) scenes: Vec<SceneNodes>,
    pub(super) nodes: Vec<Node>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) accessors: Vec<Accessor>,
    pub(super) buffer_views: Vec<BufferView>,
    pub(super) buffers: Vec<Buffer>,
    pub(super) images: Vec<Image>,
    pub(super) materials: Vec<IgnoredAny>,
    pub(super) extensions: RootExtensions,
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions_required: Vec<String>,
}

/// `asset`.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Asset {
    pub(super) version: Option<String>,
    /// Not in the specification, widely written: X, Y or Z.
    pub(super) gltf_up_axis: Option<String>,
    pub(super) extras: Option<serde_json::Value>,
}

/// An element of `scenes`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SceneNodes {
    pub(super) nodes: Vec<u64>,
}

/// An element of `nodes`; transforms as f64, unlike in the `gltf` crate.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub(super) children: Vec<u64>,
    pub(super) mesh: Option<u64>,
    pub(super) skin: Option<u64>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
}

/// An element of `meshes`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Mesh {
    pub(super) primitives: Vec<Primitive>,
}

/// A primitive.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Primitive {
    pub(super) attributes: BTreeMap<String, u64>,
    pub(super) indices: Option<u64>,
    pub(super) mode: Option<u64>,
    pub(super) targets: Option<Vec<IgnoredAny>>,
    pub(super) extensions: BTreeMap<String, IgnoredAny>,
}

/// An element of `accessors`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<u64>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u64,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Sparse>,
}

/// `accessor.sparse`.
#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

/// `accessor.sparse.indices`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: u64,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u64,
}

/// `accessor.sparse.values`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: u64,
    #[serde(default)]
    pub(super) byte_offset: u64,
}

/// An element of `bufferViews`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: u64,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

/// An element of `buffers`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: u64,
}

/// An element of `images`.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Image {
    pub(super) uri: Option<String>,
}

/// Root `extensions` that move geometry.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct RootExtensions {
    #[serde(rename = "CESIUM_RTC")]
    pub(super) cesium_rtc: Option<CesiumRtc>,
}

/// `CESIUM_RTC`.
#[derive(Debug, Deserialize)]
pub(super) struct CesiumRtc {
    pub(super) center: [f64; 3],
}

/// Required extensions that leave triangles where they are, or that this reader decodes.
const KNOWN: [&str; 6] = [
    "KHR_mesh_quantization",
    "KHR_materials_unlit",
    "KHR_texture_transform",
    "EXT_texture_webp",
    "KHR_texture_basisu",
    "CESIUM_RTC",
];

/// Parses a JSON chunk and refuses documents that need an extension this version does not know.
pub(super) fn parse(json: &[u8]) -> Result<Document, Fault> {
    if !json.trim_ascii_start().starts_with(b"{") {
        return Err(json_fault("/", "the JSON chunk holds no object")); // serde would take an array for one
    }
    let document: Document = serde_json::from_slice(json).map_err(|e| json_fault("/", e.to_string()))?;
    let Some(version) = document.asset.version.as_deref() else {
        return Err(json_fault("/asset/version", "the glTF version is absent"));
    };
    if !version.starts_with("2.") {
        let problem = format!("glTF version \"{}\"", version.escape_debug());
        let place = Place::Json("/asset/version".to_owned());
        return Err(Fault::unsupported(place, problem, "convert it: npx 3d-tiles-tools upgrade"));
    }
    document.extensions_required.iter().try_for_each(|name| check_required(name))?;
    Ok(document)
}

/// Refuses a required extension that this version does not decode.
pub(super) fn check_required(name: &str) -> Result<(), Fault> {
    let (problem, advice) = match name {
        _ if KNOWN.contains(&name) => return Ok(()),
        "KHR_draco_mesh_compression" => (
            "the geometry is compressed with Draco (KHR_draco_mesh_compression), which this build does not decode".to_owned(),
            "unpack it: npx @gltf-transform/cli copy in.glb out.glb",
        ),
        "EXT_meshopt_compression" => (
            "the geometry is compressed with meshopt (EXT_meshopt_compression), which this build does not decode".to_owned(),
            "unpack it: npx @gltf-transform/cli copy in.glb out.glb",
        ),
        _ => (
            format!("the required extension {}", name.escape_debug()),
            "export the tile without it",
        ),
    };
    Err(Fault::unsupported(Place::Json("/extensionsRequired".to_owned()), problem, advice))
}
