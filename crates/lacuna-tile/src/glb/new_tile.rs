//! A GLB tile for a cell that has none.

use super::append::{check_size, patch_node, write_file};
use super::container::{self, Chunks};
use super::document::{self, Document};
use super::draft::{Base, Draft, NAME};
use super::edit::RawObject;
use super::frame::{leading_transform, vertex_frame, world_to_scene};
use super::json_fault;
use super::nodes::instances;
use super::patch::free_to_local;
use crate::error::TileError;
use crate::fault::Fault;
use crate::patches::check_patches;
use crate::source::load;
use crate::types::{HolePatch, NewTileRequest, ReadOptions, Written};
use glam::DAffine3;
use serde_json::{Value, json};

/// Writes a tile with one mesh that holds the patches.
///
/// Up axis, `CESIUM_RTC` and node transform are the template's, so the frame that `read_tile` gives for the template rounds
/// positions as this file does: a border shared with the template stays identical.
///
/// # Errors
/// As `new_tile` of the crate.
pub(crate) fn new_tile(request: &NewTileRequest<'_>) -> Result<Written, TileError> {
    let options = ReadOptions { skip_hash: true, ..request.options.clone() };
    let source = load(request.template, &options)?;
    check_patches(request.output, request.patches, 0)?;
    let (json, bytes) = document_of(&source.bytes, request).map_err(|fault| fault.at(request.template))?;
    check_size(request.output, container::file_bytes(json.len(), bytes.len(), 0))?;
    write_file(request.output, |file| container::write(file, &json, &[&bytes], &[]))
}

fn document_of(template: &[u8], request: &NewTileRequest<'_>) -> Result<(Vec<u8>, Vec<u8>), Fault> {
    let chunks = container::split(template)?;
    let document = document::parse(chunks.json)?;
    let world = leading_transform(&document, &instances(&document)?);
    let frame = vertex_frame(world_to_scene(&document, request.options.up_axis)?, world);
    let mut draft = Draft::new(Base::default());
    let full = request.patches.iter().filter(|patch: &&HolePatch| !patch.triangles.is_empty());
    let primitives: Vec<Value> =
        full.map(|patch| draft.primitive(patch, &free_to_local(patch, &frame))).collect();
    let json = write_json(&chunks, &document, world, &draft, &primitives);
    Ok((json.map_err(|e| json_fault("/asset", e.to_string()))?, draft.bytes))
}

fn write_json(
    template: &Chunks<'_>,
    document: &Document,
    world: DAffine3,
    draft: &Draft,
    primitives: &[Value],
) -> serde_json::Result<Vec<u8>> {
    let mut root = RawObject::default();
    root.set("asset", &asset_of(template)?)?;
    root.set("scene", &0)?;
    if primitives.is_empty() {
        root.set("scenes", &json!([{}]))?;
        return serde_json::to_vec(&root);
    }
    root.set("scenes", &json!([{ "nodes": [0] }]))?;
    root.set("nodes", &[patch_node(0, world)])?;
    root.set("meshes", &json!([{ "name": NAME, "primitives": primitives }]))?;
    root.set("materials", &[draft.material(false)])?;
    root.set("accessors", &draft.accessors)?;
    root.set("bufferViews", &draft.views)?;
    root.set("buffers", &json!([{ "byteLength": draft.bytes.len() }]))?;
    if let Some(rtc) = &document.extensions.cesium_rtc {
        root.set("extensionsUsed", &["CESIUM_RTC"])?;
        root.set("extensionsRequired", &["CESIUM_RTC"])?;
        root.set("extensions", &json!({ "CESIUM_RTC": { "center": rtc.center } }))?;
    }
    serde_json::to_vec(&root)
}

/// Version and generator, and the marks of the template that say which axis is up.
fn asset_of(template: &Chunks<'_>) -> serde_json::Result<RawObject> {
    let root: RawObject = serde_json::from_slice(template.json)?;
    let old = RawObject::parse(root.get("asset").unwrap_or("{}"))?;
    let mut asset = RawObject::default();
    asset.set("version", &"2.0")?;
    asset.set("generator", &"lacuna")?;
    for key in ["gltfUpAxis", "extras"] {
        if let Some(text) = old.get(key) {
            asset.set(key, &serde_json::from_str::<&serde_json::value::RawValue>(text)?)?;
        }
    }
    Ok(asset)
}
