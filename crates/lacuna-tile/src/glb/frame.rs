//! From glTF world coordinates to the scene: up axis, then `CESIUM_RTC`.

use super::document::Document;
use super::json_fault;
use super::nodes::Instance;
use crate::fault::Fault;
use crate::types::{NumberType, UpAxis, VertexFrame};
use glam::{DAffine3, DVec3};

/// glTF world coordinates to scene coordinates (metres, z up).
///
/// The up axis is the caller's, else `asset.gltfUpAxis`, else `asset.extras.upAxis`, else y. x up is turned as in Cesium:
/// scene = (-z, y, x).
///
/// # Errors
/// An up axis that is not X, Y or Z.
pub(super) fn world_to_scene(document: &Document, up_axis: Option<UpAxis>) -> Result<DAffine3, Fault> {
    let turn = match (up_axis, written_axis(document)) {
        (Some(axis), _) => axis.to_scene(),
        (None, None | Some("Y" | "y")) => UpAxis::Y.to_scene(),
        (None, Some("Z" | "z")) => UpAxis::Z.to_scene(),
        (None, Some("X" | "x")) => DAffine3::from_cols(DVec3::Z, DVec3::Y, DVec3::NEG_X, DVec3::ZERO),
        (None, Some(other)) => {
            let problem = format!("the up axis is \"{}\", not X, Y or Z", other.escape_debug());
            return Err(json_fault("/asset", problem));
        }
    };
    let center = document.extensions.cesium_rtc.as_ref().map_or([0.0; 3], |rtc| rtc.center);
    Ok(DAffine3 { translation: DVec3::from_array(center), ..turn })
}

fn written_axis(document: &Document) -> Option<&str> {
    let asset = &document.asset;
    asset.gltf_up_axis.as_deref().or_else(|| asset.extras.as_ref()?.get("upAxis")?.as_str())
}

/// The node transform that patches without a rim take over: that of the first mesh with triangles, else of the first
/// mesh, else none.
pub(super) fn leading_transform(document: &Document, instances: &[Instance]) -> DAffine3 {
    let has_triangles = |i: &&Instance| {
        document.meshes[i.mesh].primitives.iter().any(|p| matches!(p.mode.unwrap_or(4), 4..=6))
    };
    let leading = instances.iter().find(has_triangles).or_else(|| instances.first());
    leading.map_or(DAffine3::IDENTITY, |instance| instance.world)
}

/// The frame of positions stored under a node transform.
pub(super) fn vertex_frame(to_scene: DAffine3, world: DAffine3) -> VertexFrame {
    VertexFrame { number: NumberType::F32, to_scene: to_scene * world }
}
