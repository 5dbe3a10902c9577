//! Scenes as the bench reads them: tiles as triangles, and the truth.

use anyhow::{Context, Result, bail};
use glam::DVec3;
use lacuna_mesh::TriMesh;
use lacuna_tile::{ReadOptions, SceneOptions, open_scene, read_tile};
use std::collections::BTreeMap;
use std::path::Path;

/// A vertex that a hole took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthPoint {
    /// Where it stood, metres.
    pub position: DVec3,
    /// Number of the hole.
    pub hole: u32,
}

/// Tiles by relative path.
pub type Tiles = BTreeMap<String, TriMesh>;

/// Reads all tiles of a folder.
///
/// # Errors
/// A folder without tiles, a tile that can't be read.
pub fn read_tiles(folder: &Path) -> Result<Tiles> {
    let scene = open_scene(folder, &SceneOptions::default()).with_context(|| folder.display().to_string())?;
    let mut tiles = Tiles::new();
    for entry in &scene.tiles {
        let read = read_tile(&scene.path(entry), entry.format, &ReadOptions::default())?;
        tiles.insert(entry.relative.clone(), read.mesh);
    }
    Ok(tiles)
}

/// Reads `truth.csv`, without the vertices on the area's outer border and without the holes that lie at it (class II):
/// by default nobody fills them.
///
/// # Errors
/// A file that is missing or has a line that is no point.
pub fn read_truth(folder: &Path) -> Result<Vec<TruthPoint>> {
    let external = external_holes(folder)?;
    let path = folder.join("truth.csv");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let mut points = Vec::new();
    for (number, line) in text.lines().enumerate().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [x, y, z, hole] = fields[..fields.len().min(4)] else {
            bail!("{}:{}: a point has x, y, z and hole", path.display(), number + 1);
        };
        let position = DVec3::new(x.parse()?, y.parse()?, z.parse()?);
        let hole: u32 = hole.parse()?;
        let is_on_border = fields.get(4) == Some(&"1");
        if !is_on_border && !external.contains(&hole) {
            points.push(TruthPoint { position, hole });
        }
    }
    Ok(points)
}

/// Numbers of the holes of which a piece is of class II.
fn external_holes(folder: &Path) -> Result<Vec<u32>> {
    let path = folder.join("scene.json");
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let scene: serde_json::Value = serde_json::from_str(&text)?;
    let holes = scene["holes"].as_array().map_or(&[][..], Vec::as_slice);
    let is_external = |hole: &serde_json::Value| {
        let classes = hole["cells"].as_object();
        classes.is_some_and(|c| c.values().any(|k| k.as_str().is_some_and(|k| k.starts_with("II"))))
    };
    Ok((0..).zip(holes).filter(|(_, h)| is_external(h)).map(|(k, _)| k).collect())
}

/// All tiles in one mesh; vertices stay apart.
#[must_use]
pub fn merged(tiles: &Tiles) -> TriMesh {
    let mut mesh = TriMesh::default();
    for tile in tiles.values() {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&tile.positions);
        mesh.triangles.extend(tile.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

/// Positions on the boundary of the merged tiles, those on the outline of their box left out: the rims of holes, and what
/// a ragged outline has.
#[must_use]
pub fn rim_positions(tiles: &Tiles) -> Vec<DVec3> {
    let mesh = merged(tiles);
    let low = mesh.positions.iter().fold(DVec3::INFINITY, |m, p| m.min(*p)).truncate();
    let high = mesh.positions.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p)).truncate();
    let near_m = 1e-6 * (high - low).max_element();
    let is_inside = |p: &DVec3| {
        let p = p.truncate();
        (p - low).min(high - p).min_element() > near_m
    };
    lacuna_mesh::boundary(&mesh).points.iter().map(|p| p.position).filter(is_inside).collect()
}
