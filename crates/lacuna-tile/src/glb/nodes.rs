//! The node hierarchy: which mesh stands where.

use super::document::{Document, Node};
use super::{element, json_fault};
use crate::fault::Fault;
use glam::{DAffine3, DMat4, DQuat, DVec3};

/// A mesh as a node places it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instance {
    /// Index into `nodes`.
    pub(super) node: usize,
    /// Index into `meshes`.
    pub(super) mesh: usize,
    /// Mesh coordinates to glTF world coordinates (before the up axis is turned).
    pub(super) world: DAffine3,
}

/// The meshes of the document's scene in depth-first order, children in the order written.
///
/// The scene is `scene`, else the first of `scenes`, else all nodes that are nobody's child. Transforms are composed in
/// f64: real tiles hold earth-centred translations of 4e6 m. The walk needs no stack of calls, so depth does no harm.
///
/// # Errors
/// An index out of range; a node that is reached twice (a cycle, or two parents); a matrix that is not affine.
pub(super) fn instances(document: &Document) -> Result<Vec<Instance>, Fault> {
    let mut visited = vec![false; document.nodes.len()];
    let mut found = Vec::new();
    let roots = root_nodes(document)?;
    let mut waiting: Vec<(u64, DAffine3)> = roots.iter().rev().map(|&n| (n, DAffine3::IDENTITY)).collect();
    while let Some((index, parent)) = waiting.pop() {
        let node = element(&document.nodes, index, "node", "/nodes")?;
        let at = index as usize; // in range: the element was found
        if std::mem::replace(&mut visited[at], true) {
            return Err(json_fault(
                format!("/nodes/{at}"),
                "the node is reached twice: a cycle or two parents",
            ));
        }
        let world = parent * local_transform(node, at)?;
        if let Some(mesh) = node.mesh {
            element(&document.meshes, mesh, "mesh", &format!("/nodes/{at}/mesh"))?;
            found.push(Instance { node: at, mesh: mesh as usize, world });
        }
        waiting.extend(node.children.iter().rev().map(|&child| (child, world)));
    }
    Ok(found)
}

/// The scene whose nodes are shown, as an index into `scenes`.
pub(super) fn default_scene(document: &Document) -> Option<u64> {
    document.scene.or(if document.scenes.is_empty() { None } else { Some(0) })
}

fn root_nodes(document: &Document) -> Result<Vec<u64>, Fault> {
    if let Some(scene) = default_scene(document) {
        return Ok(element(&document.scenes, scene, "scene", "/scene")?.nodes.clone());
    }
    let mut is_child = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(flag) = usize::try_from(*child).ok().and_then(|c| is_child.get_mut(c)) {
            *flag = true;
        }
    }
    Ok((0..document.nodes.len() as u64).filter(|&n| !is_child[n as usize]).collect())
}

fn local_transform(node: &Node, at: usize) -> Result<DAffine3, Fault> {
    let Some(matrix) = &node.matrix else {
        let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
        let rotation = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
        let translation = node.translation.map_or(DVec3::ZERO, DVec3::from_array);
        return Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation));
    };
    let matrix = DMat4::from_cols_array(matrix);
    if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
        return Err(json_fault(format!("/nodes/{at}/matrix"), "the last row is not 0 0 0 1"));
    }
    Ok(DAffine3::from_mat4(matrix))
}
