//! A GLB tile in memory: its mesh, and where each vertex comes from.

use super::accessor::{Component, Elements};
use super::buffer::{self, Buffers};
use super::container::{self, Chunks};
use super::document::{self, Document, Primitive};
use super::frame::{leading_transform, vertex_frame, world_to_scene};
use super::nodes::{Instance, instances};
use super::topology::{triangle_count, triangles};
use super::{element, json_fault};
use crate::error::TileError;
use crate::fault::{Fault, reserve};
use crate::mesh::drop_non_finite;
use crate::source::{Source, load};
use crate::types::{ReadOptions, ReadTile};
use glam::{DAffine3, DVec3};
use lacuna_mesh::TriMesh;
use std::mem::size_of;
use std::path::Path;

/// A tile may take this much memory a byte of its file: a file could place one mesh a million times.
const MEMORY_PER_FILE_BYTE: u64 = 64;
/// Memory that any tile may take, bytes.
const MEMORY_FLOOR_BYTES: u64 = 16 << 20;

/// Memory that a tile of so many bytes may take.
pub(super) fn allowed_memory_bytes(file_bytes: u64) -> u64 {
    file_bytes.saturating_mul(MEMORY_PER_FILE_BYTE).saturating_add(MEMORY_FLOOR_BYTES)
}

/// Vertices that come from one position accessor under one node, one after another in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// Id of the first vertex.
    pub(super) first: u32,
    /// Number of vertices.
    pub(super) count: u32,
    /// Index into `Model::instances`.
    pub(super) instance: usize,
    /// First primitive of the mesh that uses them.
    pub(super) primitive: usize,
    /// The position accessor.
    pub(super) accessor: u64,
}

/// A tile as read, with what appending needs.
#[derive(Debug)]
pub(super) struct Model<'a> {
    pub(super) chunks: Chunks<'a>,
    pub(super) document: Document,
    pub(super) buffers: Buffers<'a>,
    pub(super) instances: Vec<Instance>,
    /// glTF world coordinates to scene coordinates.
    pub(super) to_scene: DAffine3,
    /// Node transform for patches without a rim.
    pub(super) leading: DAffine3,
    /// Ascending by `first`.
    pub(super) runs: Vec<Run>,
    pub(super) mesh: TriMesh,
    pub(super) warnings: Vec<String>,
}

/// Reads a GLB tile: the triangles of its scene, in the order of nodes, primitives and indices.
///
/// # Errors
/// As `read_tile`.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<ReadTile, TileError> {
    let Source { bytes, hash } = load(path, options)?;
    let model = parse(path, &bytes, options)?;
    let images = model.document.images.iter().filter_map(|image| image.uri.clone());
    Ok(ReadTile {
        frame: vertex_frame(model.to_scene, model.leading),
        hash,
        bytes: bytes.len() as u64,
        has_colour: model.runs.iter().any(|run| model.primitive(run).attributes.contains_key("COLOR_0")),
        textures: images.filter(|uri| !uri.starts_with("data:")).collect(),
        warnings: model.warnings,
        mesh: model.mesh,
    })
}

/// Reads the tile that lies in `file`.
///
/// # Errors
/// `Malformed`, `Unsupported`.
pub(super) fn parse<'a>(path: &Path, file: &'a [u8], options: &ReadOptions) -> Result<Model<'a>, TileError> {
    parse_faulty(path, file, options).map_err(|fault| fault.at(path))
}

fn parse_faulty<'a>(path: &Path, file: &'a [u8], options: &ReadOptions) -> Result<Model<'a>, Fault> {
    let chunks = container::split(file)?;
    let document = document::parse(chunks.json)?;
    let instances = instances(&document)?;
    let buffers = buffer::resolve(&document, chunks.bin, path.parent().unwrap_or(Path::new("")))?;
    let mut model = Model {
        to_scene: world_to_scene(&document, options.up_axis)?,
        leading: leading_transform(&document, &instances),
        chunks,
        runs: Vec::new(),
        mesh: TriMesh::default(),
        warnings: Vec::new(),
        document,
        buffers,
        instances,
    };
    let memory = allowed_memory_bytes(file.len() as u64);
    let mut reader = Reader { memory, skipped: 0, joins: 0 };
    for at in 0..model.instances.len() {
        reader.instance(&mut model, at)?;
    }
    reader.finish(&mut model);
    Ok(model)
}

impl Model<'_> {
    /// The run that a vertex belongs to.
    pub(super) fn run_of(&self, vertex: u32) -> Option<&Run> {
        let after = self.runs.partition_point(|run| run.first <= vertex);
        self.runs.get(after.checked_sub(1)?).filter(|run| vertex - run.first < run.count)
    }

    /// The first primitive that uses a run's vertices.
    pub(super) fn primitive(&self, run: &Run) -> &Primitive {
        &self.document.meshes[self.instances[run.instance].mesh].primitives[run.primitive]
    }

    /// An accessor of this tile.
    pub(super) fn elements(&self, accessor: u64) -> Result<Elements<'_>, Fault> {
        Elements::open(&self.document, &self.buffers, accessor)
    }
}

/// Counts over one reading.
struct Reader {
    /// Bytes of memory that may still be taken.
    memory: u64,
    /// Primitives without triangles.
    skipped: usize,
    /// Triangles of strips and fans that name an index twice.
    joins: usize,
}

impl Reader {
    fn instance(&mut self, model: &mut Model<'_>, at: usize) -> Result<(), Fault> {
        let Instance { mesh, world, node } = model.instances[at];
        if model.document.nodes[node].skin.is_some() {
            model.warnings.push(format!("node {node}: its skin is not applied"));
        }
        let to_scene = model.to_scene * world;
        for primitive in 0..model.document.meshes[mesh].primitives.len() {
            let pointer = format!("/meshes/{mesh}/primitives/{primitive}");
            self.primitive(model, at, primitive, to_scene, &pointer)?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        model: &mut Model<'_>,
        instance: usize,
        at: usize,
        to_scene: DAffine3,
        pointer: &str,
    ) -> Result<(), Fault> {
        let primitive = &model.document.meshes[model.instances[instance].mesh].primitives[at];
        let mode = primitive.mode.unwrap_or(4);
        if mode > 6 {
            return Err(json_fault(pointer, format!("mode {mode} is none of glTF's")));
        }
        let position = primitive.attributes.get("POSITION").copied();
        let Some(accessor) = position.filter(|_| mode >= 4) else {
            self.skipped += 1;
            return Ok(());
        };
        check_not_draco(&model.document, primitive, accessor, pointer)?;
        let indices = primitive.indices;
        let known = model.runs.iter().rev().take_while(|run| run.instance == instance);
        let run = match known.copied().find(|run| run.accessor == accessor) {
            Some(run) => run,
            None => self.positions(
                model,
                Run { first: 0, count: 0, instance, primitive: at, accessor },
                to_scene,
            )?,
        };
        self.triangles(model, mode, indices, &run, to_scene.matrix3.determinant() < 0.0, pointer)
    }

    /// Appends the vertices of a position accessor.
    fn positions(&mut self, model: &mut Model<'_>, run: Run, to_scene: DAffine3) -> Result<Run, Fault> {
        let pointer = format!("/accessors/{}", run.accessor);
        let elements = Elements::open(&model.document, &model.buffers, run.accessor)?;
        if elements.width != 3 || elements.component == Component::U32 {
            return Err(json_fault(pointer, "positions are not a VEC3 of floats or of 8 or 16 bit integers"));
        }
        self.take(elements.count as u64, size_of::<DVec3>(), &pointer)?;
        let ids = u32::try_from(model.mesh.positions.len()).ok().zip(u32::try_from(elements.count).ok());
        let Some((first, count)) = ids.filter(|(first, count)| first.checked_add(*count).is_some()) else {
            return Err(json_fault(pointer, "more vertices than a 32 bit id can count"));
        };
        reserve(&mut model.mesh.positions, elements.count as u64)?;
        let scene = |k| to_scene.transform_point3(local(elements.vec3(k)));
        model.mesh.positions.extend((0..elements.count).map(scene));
        let run = Run { first, count, ..run };
        model.runs.push(run);
        Ok(run)
    }

    /// Appends the triangles of a primitive. A mirroring node transform turns them over, as the specification says.
    fn triangles(
        &mut self,
        model: &mut Model<'_>,
        mode: u64,
        indices: Option<u64>,
        run: &Run,
        mirrored: bool,
        pointer: &str,
    ) -> Result<(), Fault> {
        let indices = match indices {
            Some(accessor) => Some(open_indices(&model.document, &model.buffers, accessor)?),
            None => None,
        };
        let corners = indices.as_ref().map_or(run.count as usize, |i| i.count);
        if mode == 4 && corners % 3 != 0 {
            model.warnings.push(format!("{pointer}: {} corners are left over", corners % 3));
        }
        let count = triangle_count(mode, corners) as u64;
        self.take(count, size_of::<[u32; 3]>(), pointer)?;
        reserve(&mut model.mesh.triangles, count)?;
        for places in triangles(mode, corners) {
            let [a, b, c] = places.map(|k| indices.as_ref().map_or(k as u32, |i| i.index(k)));
            if let Some(bad) = [a, b, c].into_iter().find(|&v| v >= run.count) {
                return Err(json_fault(
                    pointer,
                    format!("index {bad}, but there are {} vertices", run.count),
                ));
            }
            if mode != 4 && (a == b || b == c || c == a) {
                self.joins += 1;
                continue;
            }
            let [b, c] = if mirrored { [c, b] } else { [b, c] };
            model.mesh.triangles.push([a, b, c].map(|v| run.first + v));
        }
        Ok(())
    }

    fn take(&mut self, count: u64, size: usize, pointer: &str) -> Result<(), Fault> {
        let left = count.checked_mul(size as u64).and_then(|bytes| self.memory.checked_sub(bytes));
        self.memory = left.ok_or_else(|| {
            json_fault(pointer, format!("{count} elements are out of proportion to the size of the file"))
        })?;
        Ok(())
    }

    fn finish(self, model: &mut Model<'_>) {
        if self.skipped > 0 {
            model.warnings.push(format!("{} primitives without triangles pass through", self.skipped));
        }
        if model.mesh.triangles.is_empty() {
            model.warnings.push("no triangles: there is nothing to repair".to_owned());
        }
        let dropped = drop_non_finite(&mut model.mesh);
        model.warnings.extend(dropped);
    }
}

/// A Draco primitive may carry plain accessors as well; without them its positions would read as zeros.
fn check_not_draco(
    document: &Document,
    primitive: &Primitive,
    position: u64,
    pointer: &str,
) -> Result<(), Fault> {
    let is_draco = primitive.extensions.contains_key("KHR_draco_mesh_compression");
    let accessor = element(&document.accessors, position, "accessor", pointer)?;
    if is_draco && accessor.buffer_view.is_none() {
        return document::check_required("KHR_draco_mesh_compression");
    }
    Ok(())
}

fn open_indices<'b>(
    document: &Document,
    buffers: &'b Buffers<'_>,
    accessor: u64,
) -> Result<Elements<'b>, Fault> {
    element(&document.accessors, accessor, "accessor", "/meshes")?;
    let elements = Elements::open(document, buffers, accessor)?;
    let unsigned = matches!(elements.component, Component::U8 | Component::U16 | Component::U32);
    if elements.width != 1 || !unsigned {
        return Err(json_fault(
            format!("/accessors/{accessor}"),
            "indices are not a SCALAR of unsigned integers",
        ));
    }
    Ok(elements)
}

/// A stored position as f64.
pub(super) fn local(stored: [f32; 3]) -> DVec3 {
    DVec3::from_array(stored.map(f64::from))
}
