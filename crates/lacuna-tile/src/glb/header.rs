//! How large a GLB tile is, from its JSON chunk alone.

use super::container::{JSON_START, check_header, trim_padding, u32_at};
use super::document::{self, Document, Primitive};
use super::model::allowed_memory_bytes;
use super::nodes::instances;
use super::topology::triangle_count;
use super::{element, json_fault};
use crate::error::{Place, TileError};
use crate::fault::{Fault, reserve};
use crate::source::open_regular;
use crate::types::TileHeader;
use glam::DVec3;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Reads the number of vertices and triangles that the accessors of the scene's meshes declare, as far as they are in
/// proportion to the size of the file.
///
/// # Errors
/// `Io`; `Malformed`; `Unsupported` for a required extension that this version does not decode.
pub(crate) fn read_header(path: &Path) -> Result<TileHeader, TileError> {
    let (mut file, metadata) = open_regular(path)?;
    let bytes = metadata.len();
    let json = read_json(&mut file, bytes, path)?;
    count(&json, bytes).map_err(|fault| fault.at(path))
}

fn read_json(file: &mut File, bytes: u64, path: &Path) -> Result<Vec<u8>, TileError> {
    let io = |e| TileError::io(path, "read", e);
    let mut start = [0; JSON_START];
    match file.read_exact(&mut start) {
        Ok(()) => {}
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            return Err(Fault::malformed(Place::File, format!("{bytes} bytes are no GLB file")).at(path));
        }
        Err(e) => return Err(io(e)),
    }
    check_header(&start).map_err(|fault| fault.at(path))?;
    let length = u64::from(u32_at(&start, 12));
    if start[16..] != *b"JSON" || length > bytes.saturating_sub(JSON_START as u64) {
        return Err(Fault::malformed(Place::Byte(12), "no JSON chunk that fits the file").at(path));
    }
    let mut json = Vec::new();
    reserve(&mut json, length).map_err(|fault| fault.at(path))?;
    file.take(length).read_to_end(&mut json).map_err(io)?;
    Ok(json)
}

fn count(json: &[u8], bytes: u64) -> Result<TileHeader, Fault> {
    let document = document::parse(trim_padding(json))?;
    let mut header = TileHeader { vertices: 0, triangles: 0, bytes };
    for instance in instances(&document)? {
        let mut counted = Vec::new();
        for primitive in &document.meshes[instance.mesh].primitives {
            let Some((position, vertices, triangles)) = primitive_size(&document, primitive)? else {
                continue;
            };
            header.triangles = header.triangles.saturating_add(triangles);
            // Primitives of one mesh that share their positions are read as sharing them.
            if !counted.contains(&position) {
                counted.push(position);
                header.vertices = header.vertices.saturating_add(vertices);
            }
        }
    }
    check_proportion(&header)?;
    Ok(header)
}

/// The reader's own rule: counts that it will refuse are no reason to ask for that much memory.
fn check_proportion(header: &TileHeader) -> Result<(), Fault> {
    let positions = header.vertices.saturating_mul(size_of::<DVec3>() as u64);
    let triangles = header.triangles.saturating_mul(size_of::<[u32; 3]>() as u64);
    if positions.saturating_add(triangles) <= allowed_memory_bytes(header.bytes) {
        return Ok(());
    }
    let problem = format!(
        "{} vertices and {} triangles are out of proportion to the {} bytes of the file",
        header.vertices, header.triangles, header.bytes
    );
    Err(json_fault("/accessors", problem))
}

/// Position accessor, vertices and triangles; `None` for points, lines and primitives without positions.
fn primitive_size(document: &Document, primitive: &Primitive) -> Result<Option<(u64, u64, u64)>, Fault> {
    let mode = primitive.mode.unwrap_or(4);
    let Some(&position) = primitive.attributes.get("POSITION").filter(|_| matches!(mode, 4..=6)) else {
        return Ok(None);
    };
    let count_of = |index| element(&document.accessors, index, "accessor", "/meshes").map(|a| a.count);
    let vertices = count_of(position)?;
    let corners = primitive.indices.map_or(Ok(vertices), count_of)?;
    let triangles = triangle_count(mode, usize::try_from(corners).unwrap_or(usize::MAX)) as u64;
    Ok(Some((position, vertices, triangles)))
}
