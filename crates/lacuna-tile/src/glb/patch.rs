//! One patch in the local coordinates of the mesh that takes it.

use super::accessor::{Component, Elements};
use super::frame::vertex_frame;
use super::model::{Model, local};
use crate::fault::Fault;
use crate::patches::original_corners;
use crate::types::{Corner, HolePatch, VertexFrame};
use glam::{DAffine3, DVec3};

/// A patch as it will be stored: rim copies first (by ascending id), then the new vertices.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LocalPatch {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) colours: Option<Colours>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Vertex colours, as many as positions.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Colours {
    /// Normalised bytes, as photogrammetry tiles have them.
    Bytes(Vec<[u8; 4]>),
    /// Any other source.
    Floats(Vec<[f32; 4]>),
}

/// Brings a patch into the local coordinates of a mesh that stands under the node transform `world`.
///
/// Rim vertices under the same transform are copied bit for bit; rim vertices under another one are rounded like new ones.
///
/// # Errors
/// A transform that cannot be inverted.
pub(super) fn to_local(model: &Model<'_>, patch: &HolePatch, world: DAffine3) -> Result<LocalPatch, Fault> {
    let frame = vertex_frame(model.to_scene, world);
    let originals = original_corners(patch);
    let mut positions = Vec::with_capacity(originals.len() + patch.vertices.len());
    for &vertex in &originals {
        positions.push(original_position(model, vertex, world, &frame)?);
    }
    positions.extend(patch.vertices.iter().map(|&scene| stored(&frame, scene)));
    let colours = colours(model, &originals, patch.vertices.len())?;
    let triangles = triangles(patch, &originals, frame.to_scene.matrix3.determinant() < 0.0);
    let normals = normals(&positions, &triangles, &frame);
    Ok(LocalPatch { positions, normals, colours, triangles })
}

/// A patch without a rim.
pub(super) fn free_to_local(patch: &HolePatch, frame: &VertexFrame) -> LocalPatch {
    let positions: Vec<_> = patch.vertices.iter().map(|&scene| stored(frame, scene)).collect();
    let triangles = triangles(patch, &[], frame.to_scene.matrix3.determinant() < 0.0);
    let normals = normals(&positions, &triangles, frame);
    LocalPatch { positions, normals, colours: None, triangles }
}

fn original_position(
    model: &Model<'_>,
    vertex: u32,
    world: DAffine3,
    frame: &VertexFrame,
) -> Result<[f32; 3], Fault> {
    if let Some(run) = model.run_of(vertex).filter(|run| model.instances[run.instance].world == world) {
        return Ok(model.elements(run.accessor)?.vec3((vertex - run.first) as usize));
    }
    Ok(stored(frame, model.mesh.positions[vertex as usize]))
}

/// The stored coordinates that read back as `scene`: rounded, and corrected once for what inverting the frame lost.
fn stored(frame: &VertexFrame, scene: DVec3) -> [f32; 3] {
    let first = frame.to_file(scene);
    let off = scene - frame.to_scene.transform_point3(first);
    if off == DVec3::ZERO {
        return first.as_vec3().to_array();
    }
    let second = (first + frame.to_scene.matrix3.inverse() * off).as_vec3();
    let off_now = scene - frame.to_scene.transform_point3(second.as_dvec3());
    if off_now.length_squared() < off.length_squared() {
        second.to_array()
    } else {
        first.as_vec3().to_array()
    }
}

fn triangles(patch: &HolePatch, originals: &[u32], mirrored: bool) -> Vec<[u32; 3]> {
    let slot = |corner: Corner| match corner {
        Corner::Original(v) => originals.binary_search(&v.0).unwrap_or(0) as u32, // found: made from these corners
        Corner::New(k) => originals.len() as u32 + k,
    };
    let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    patch.triangles.iter().map(|triangle| turned(triangle.map(slot))).collect()
}

/// Unit normals: the area-weighted sum over a vertex's triangles; the scene's up where that is nothing.
fn normals(positions: &[[f32; 3]], triangles: &[[u32; 3]], frame: &VertexFrame) -> Vec<[f32; 3]> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| local(positions[v as usize]));
        let weighted = (b - a).cross(c - a);
        for &v in triangle {
            sums[v as usize] += weighted;
        }
    }
    // Normals go to the scene by the inverse transpose, so they come back by the transpose.
    let up = (frame.to_scene.matrix3.transpose() * DVec3::Z).normalize_or(DVec3::Z);
    sums.iter().map(|sum| sum.normalize_or(up).as_vec3().to_array()).collect()
}

/// Colours of the rim, and their mean for the new vertices; `None` if the lowest rim vertex has none.
fn colours(model: &Model<'_>, originals: &[u32], new: usize) -> Result<Option<Colours>, Fault> {
    let Some(lead) = originals.first().map_or(Ok(None), |&v| colour_elements(model, v))? else {
        return Ok(None);
    };
    let mut all = Vec::with_capacity(originals.len() + new);
    for &vertex in originals {
        let white = [1.0; 4];
        let colour = colour_elements(model, vertex)?;
        let at = model.run_of(vertex).map_or(0, |run| (vertex - run.first) as usize);
        all.push(colour.filter(|c| at < c.count).map_or(white, |c| c.vec4(at, 1.0)));
    }
    let sum = all.iter().fold([0.0; 4], |sum: [f64; 4], c| std::array::from_fn(|k| sum[k] + f64::from(c[k])));
    let mean = sum.map(|s| (s / all.len() as f64) as f32);
    all.extend(std::iter::repeat_n(mean, new));
    let bytes = || all.iter().map(|colour| colour.map(to_byte)).collect();
    Ok(Some(if lead.component == Component::U8 { Colours::Bytes(bytes()) } else { Colours::Floats(all) }))
}

fn to_byte(value: f32) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

fn colour_elements<'m>(model: &'m Model<'_>, vertex: u32) -> Result<Option<Elements<'m>>, Fault> {
    let Some(run) = model.run_of(vertex) else { return Ok(None) };
    let accessor = model.primitive(run).attributes.get("COLOR_0");
    let elements = accessor.map(|&accessor| model.elements(accessor)).transpose()?;
    Ok(elements.filter(|e| e.width >= 3))
}
