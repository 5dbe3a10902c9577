//! Writes a GLB tile again with patches as primitives of their own.

use super::container::{self, padded};
use super::draft::{Base, Draft, NAME};
use super::edit::RawObject;
use super::json_fault;
use super::model::{Model, parse};
use super::nodes::default_scene;
use super::patch::to_local;
use super::uri::encode_base64;
use crate::atomic::AtomicFile;
use crate::error::{Place, TileError};
use crate::fault::Fault;
use crate::patches::{check_patches, original_corners};
use crate::source::load_expected;
use crate::types::{AppendRequest, HolePatch, Written};
use glam::DAffine3;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::Path;

/// Writes `request.output`: the BIN chunk begins with the original one, new elements stand at the ends of their arrays, and
/// every other part of the JSON keeps its text.
///
/// A patch becomes a primitive of the mesh that holds its rim's lowest vertex. Where that mesh stands in several places
/// (or is animated by morph targets or a skin), and where there is no rim, it goes into a mesh and node of its own with the
/// same transform.
///
/// # Errors
/// As `append_patches`.
pub(crate) fn append(request: &AppendRequest<'_>) -> Result<Written, TileError> {
    let source = load_expected(request.input, request.options, request.expected_hash)?;
    let patches: Vec<&HolePatch> = request.patches.iter().filter(|p| !p.triangles.is_empty()).collect();
    if patches.is_empty() {
        return write_file(request.output, |file| file.write_all(&source.bytes));
    }
    let model = parse(request.input, &source.bytes, request.options)?;
    check_patches(request.input, request.patches, model.mesh.positions.len() as u64)?;
    let (json, extra) = extend(&model, &patches).map_err(|fault| fault.at(request.input))?;
    write_glb(request.input, request.output, &json, &model, &extra)
}

/// Where a patch goes.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    /// A mesh that stands once.
    Mesh(usize, DAffine3),
    /// A mesh of its own under this node transform.
    Own(DAffine3),
}

impl Target {
    fn world(self) -> DAffine3 {
        match self {
            Self::Mesh(_, world) | Self::Own(world) => world,
        }
    }
}

fn target_of(model: &Model<'_>, patch: &HolePatch) -> Target {
    let lowest = original_corners(patch).first().copied();
    let Some(run) = lowest.and_then(|vertex| model.run_of(vertex)) else { return Target::Own(model.leading) };
    let instance = model.instances[run.instance];
    let document = &model.document;
    let users = document.nodes.iter().filter(|node| node.mesh == Some(instance.mesh as u64)).count();
    let is_animated = document.nodes[instance.node].skin.is_some()
        || document.meshes[instance.mesh].primitives.iter().any(|p| p.targets.is_some());
    if users == 1 && !is_animated {
        Target::Mesh(instance.mesh, instance.world)
    } else {
        Target::Own(instance.world)
    }
}

/// The new JSON text, and the bytes that follow the original BIN chunk.
fn extend(model: &Model<'_>, patches: &[&HolePatch]) -> Result<(Vec<u8>, Vec<u8>), Fault> {
    let in_bin = bytes_go_into_bin(model);
    let mut draft = Draft::new(base_of(model, in_bin));
    let mut additions: Vec<(Target, Vec<Value>)> = Vec::new();
    for patch in patches {
        let target = target_of(model, patch);
        let determinant = target.world().matrix3.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            return Err(json_fault("/nodes", "the node transform of the rim cannot be inverted"));
        }
        let local = to_local(model, patch, target.world())?;
        let primitive = draft.primitive(patch, &local);
        match additions.iter_mut().find(|(known, _)| *known == target) {
            Some((_, primitives)) => primitives.push(primitive),
            None => additions.push((target, vec![primitive])),
        }
    }
    let json = rewrite(model, &draft, &additions, in_bin).map_err(|e| json_fault("/", e.to_string()))?;
    Ok((json, if in_bin { draft.bytes } else { Vec::new() }))
}

/// New bytes follow the BIN chunk if buffer 0 is (or can become) that chunk.
fn bytes_go_into_bin(model: &Model<'_>) -> bool {
    match model.document.buffers.first() {
        None => model.chunks.bin.is_none(),
        Some(buffer) => buffer.uri.is_none() && model.chunks.bin.is_some(),
    }
}

fn base_of(model: &Model<'_>, in_bin: bool) -> Base {
    let document = &model.document;
    Base {
        buffer: if in_bin { 0 } else { document.buffers.len() },
        first_byte: if in_bin { padded(model.chunks.bin.map_or(0, <[u8]>::len)) } else { 0 },
        views: document.buffer_views.len(),
        accessors: document.accessors.len(),
        material: document.materials.len(),
    }
}

fn rewrite(
    model: &Model<'_>,
    draft: &Draft,
    additions: &[(Target, Vec<Value>)],
    in_bin: bool,
) -> serde_json::Result<Vec<u8>> {
    let mut root: RawObject = serde_json::from_slice(model.chunks.json)?;
    rewrite_buffers(&mut root, model, draft, in_bin)?;
    root.extend("bufferViews", &draft.views)?;
    root.extend("accessors", &draft.accessors)?;
    let unlit = model.document.extensions_used.iter().any(|name| name == "KHR_materials_unlit");
    root.extend("materials", &[draft.material(unlit)])?;
    let (mut meshes, mut nodes) = (model.document.meshes.len(), model.document.nodes.len());
    for (target, primitives) in additions {
        match target {
            Target::Mesh(mesh, _) => {
                root.edit_element("meshes", *mesh, |mesh| mesh.extend("primitives", primitives))?;
            }
            Target::Own(world) => {
                root.extend("meshes", &[json!({ "name": NAME, "primitives": primitives })])?;
                root.extend("nodes", &[patch_node(meshes, *world)])?;
                if let Some(scene) = default_scene(&model.document) {
                    root.edit_element("scenes", scene as usize, |scene| scene.extend("nodes", &[nodes]))?;
                }
                meshes += 1;
                nodes += 1;
            }
        }
    }
    serde_json::to_vec(&root)
}

fn rewrite_buffers(
    root: &mut RawObject,
    model: &Model<'_>,
    draft: &Draft,
    in_bin: bool,
) -> serde_json::Result<()> {
    if !in_bin {
        let uri = format!("data:application/octet-stream;base64,{}", encode_base64(&draft.bytes));
        return root.extend("buffers", &[json!({ "byteLength": draft.bytes.len(), "uri": uri })]);
    }
    let length = padded(model.chunks.bin.map_or(0, <[u8]>::len)) + draft.bytes.len();
    if model.document.buffers.is_empty() {
        return root.extend("buffers", &[json!({ "byteLength": length })]);
    }
    root.edit_element("buffers", 0, |buffer| buffer.set("byteLength", &length))
}

/// A node at the root of the scene; the matrix is left out where it is the identity.
pub(super) fn patch_node(mesh: usize, world: DAffine3) -> Value {
    let mut node = json!({ "name": NAME, "mesh": mesh });
    if world != DAffine3::IDENTITY {
        let [a, b, c] = [world.matrix3.x_axis, world.matrix3.y_axis, world.matrix3.z_axis];
        let t = world.translation;
        node["matrix"] =
            json!([a.x, a.y, a.z, 0.0, b.x, b.y, b.z, 0.0, c.x, c.y, c.z, 0.0, t.x, t.y, t.z, 1.0]);
    }
    node
}

fn write_glb(
    input: &Path,
    output: &Path,
    json: &[u8],
    model: &Model<'_>,
    extra: &[u8],
) -> Result<Written, TileError> {
    let bin = model.chunks.bin.unwrap_or(&[]);
    let gap = &[0; 3][..if extra.is_empty() { 0 } else { padded(bin.len()) - bin.len() }];
    let parts = [bin, gap, extra];
    let tail = model.chunks.tail;
    check_size(input, container::file_bytes(json.len(), parts.iter().map(|p| p.len()).sum(), tail.len()))?;
    write_file(output, |file| container::write(file, json, &parts, tail))
}

/// GLB lengths are 32 bit.
pub(super) fn check_size(path: &Path, bytes: usize) -> Result<(), TileError> {
    if u32::try_from(bytes).is_ok() {
        return Ok(());
    }
    let problem = format!("{bytes} bytes, and a GLB file ends at 4 GiB");
    Err(TileError::unsupported(path, Place::File, problem, "cut the tile"))
}

/// Writes a file that appears whole or not at all.
pub(super) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut AtomicFile) -> std::io::Result<()>,
) -> Result<Written, TileError> {
    let mut file = AtomicFile::create(path)?;
    write(&mut file).map_err(|e| TileError::io(path, "write", e))?;
    let committed = file.commit()?;
    Ok(Written { bytes: committed.bytes, hash: committed.hash, side_files: Vec::new() })
}
