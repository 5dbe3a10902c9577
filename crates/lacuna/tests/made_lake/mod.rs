//! Made lakes: 3 x 3 tiles of even ground with an elliptic hole over all of them, and what a repair made of it.

use crate::kit::SceneFolder;
use glam::{DVec2, DVec3};
use lacuna_tile::{ReadOptions, TileFormat, read_tile};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Height of the water, metres.
pub(crate) const LEVEL_M: f64 = -0.45;
const CELL: i32 = 30;
const CELLS: i32 = 3;
const CENTRE: DVec2 = DVec2::new(45.0, 45.0);

/// A lake and what stands round it.
#[derive(Clone, Copy)]
pub(crate) struct Lake {
    /// Half axes of the hole, metres.
    pub(crate) half_m: DVec2,
    /// Share of the shore that is a wall of 3 m and more.
    pub(crate) walls: f64,
    /// Heights of the shore stray by so much, metres.
    pub(crate) noise_m: f64,
    /// Rise of the water and its shore per metre eastwards.
    pub(crate) slope: f64,
    /// The shore rises and falls in hills of so many metres.
    pub(crate) hills_m: f64,
    /// Height of a raft over the water, metres, if there is one.
    pub(crate) raft_m: Option<f64>,
}

impl Default for Lake {
    fn default() -> Self {
        Self {
            half_m: DVec2::new(28.0, 24.0),
            walls: 0.0,
            noise_m: 0.08,
            slope: 0.0,
            hills_m: 0.0,
            raft_m: None,
        }
    }
}

/// Corners of the raft.
const RAFT: [DVec2; 2] = [DVec2::new(42.0, 24.0), DVec2::new(47.0, 27.0)];

impl Lake {
    /// Height of the ground.
    fn height_m(&self, i: i32, j: i32) -> f64 {
        let p = DVec2::new(f64::from(i), f64::from(j));
        if let Some(raft_m) = self.raft_m.filter(|_| is_raft(p)) {
            return LEVEL_M + raft_m;
        }
        let d = p - CENTRE;
        let beyond_m = ((d / self.half_m).length() - 1.0).max(0.0) * self.half_m.min_element();
        let turn = d.y.atan2(d.x) / std::f64::consts::TAU + 0.5;
        let shore = LEVEL_M + self.slope * d.x + self.noise_m * noise(i, j);
        let hills = self.hills_m * (0.12 * p.x + 0.3).sin() * (0.1 * p.y).cos();
        let wall = if turn < self.walls { 3.0 + noise(j, i).abs() } else { 0.0 };
        shore + hills + wall + 0.1 * (beyond_m - 1.5).max(0.0)
    }

    fn takes(&self, centroid: DVec2) -> bool {
        let is_left = self.raft_m.is_some() && is_raft(centroid);
        ((centroid - CENTRE) / self.half_m).length() < 1.0 && !is_left
    }

    /// Writes the tiles.
    pub(crate) fn scene(&self) -> SceneFolder {
        SceneFolder::new(|path| {
            for (i, j) in (0..CELLS).flat_map(|j| (0..CELLS).map(move |i| (i, j))) {
                self.write_tile(path, i, j);
            }
        })
    }

    fn write_tile(&self, scene: &Path, column: i32, row: i32) {
        let mut numbers: BTreeMap<(i32, i32), usize> = BTreeMap::new();
        let (mut vertices, mut faces) = (String::new(), String::new());
        let mut count = 0;
        let squares = (0..CELL).flat_map(|y| (0..CELL).map(move |x| (column * CELL + x, row * CELL + y)));
        for (i, j) in squares {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            for triangle in [[a, b, c], [a, c, d]] {
                let place = |(i, j): (i32, i32)| DVec2::new(f64::from(i), f64::from(j));
                if self.takes(triangle.map(place).iter().sum::<DVec2>() / 3.0) {
                    continue;
                }
                let corners = triangle.map(|node| {
                    let next = numbers.len();
                    *numbers.entry(node).or_insert_with(|| {
                        let z = self.height_m(node.0, node.1);
                        writeln!(vertices, "{} {} {z}", node.0, node.1).expect("memory");
                        next
                    })
                });
                writeln!(faces, "3 {} {} {}", corners[0], corners[1], corners[2]).expect("memory");
                count += 1;
            }
        }
        if count == 0 {
            return;
        }
        let name = format!("Tile_{column:+04}_{row:+04}");
        std::fs::create_dir_all(scene.join(&name)).expect("a folder");
        let head = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             element face {count}\nproperty list uchar int vertex_indices\nend_header\n",
            numbers.len()
        );
        std::fs::write(scene.join(&name).join(format!("{name}.ply")), head + &vertices + &faces)
            .expect("a tile");
    }
}

fn is_raft(p: DVec2) -> bool {
    p.cmpge(RAFT[0]).all() && p.cmple(RAFT[1]).all()
}

/// Repeatable numbers in [-1, 1].
fn noise(i: i32, j: i32) -> f64 {
    let x = (f64::from(i) * 12.9898 + f64::from(j) * 78.233).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// New vertices of a repair with their distance from the nearest delivered one, metres.
pub(crate) fn new_vertices(scene: &SceneFolder, out: &Path) -> Vec<(DVec3, f64)> {
    let positions = |path: &Path| -> Vec<DVec3> {
        let read = read_tile(path, TileFormat::Ply, &ReadOptions::default());
        read.map_or_else(|_| Vec::new(), |tile| tile.mesh.positions)
    };
    let (mut delivered, mut new) = (Vec::new(), Vec::new());
    for (i, j) in (0..CELLS).flat_map(|j| (0..CELLS).map(move |i| (i, j))) {
        let name = format!("Tile_{i:+04}_{j:+04}");
        let before = positions(&scene.tile(&name));
        let after = positions(&crate::kit::scene_folder::tile_of(out, &name));
        new.extend(after.into_iter().skip(before.len()));
        delivered.extend(before);
    }
    let nearest = |p: &DVec3| {
        let away = |q: &DVec3| q.truncate().distance_squared(p.truncate());
        delivered.iter().map(away).fold(f64::INFINITY, f64::min).sqrt()
    };
    new.into_iter().map(|p| (p, nearest(&p))).collect()
}
