//! Other heights for a made scene, and rims that are disturbed as real ones are.

use crate::case::{Ground, RimFault};
use crate::dem::Elevation;
use crate::scene_files::{Tiles, read_tiles, rim_positions};
use anyhow::{Context, Result, bail};
use glam::DVec3;
use lacuna_mesh::position_bits;
use scene::random::{hash, unit};
use std::collections::HashMap;
use std::path::Path;

/// Short waves of rough ground: wavelength and amplitude, metres.
const SHORT_WAVES: [[f64; 2]; 4] = [[61.0, 0.30], [29.0, 0.18], [13.0, 0.09], [6.1, 0.04]];
/// Least and largest error of an outlier, metres.
const OUTLIER_M: [f64; 2] = [0.4, 1.2];

/// Rewrites the heights of all tiles and of the truth, and disturbs the two rings of vertices round the holes (of the tiles
/// alone). Equal places stay equal in every tile. Tiles must be binary PLY as the tool `scene` writes it.
///
/// # Errors
/// Tiles of another layout, files that can't be read or written, missing elevation data.
pub fn rework(folder: &Path, ground: Ground, rim: RimFault, seed: u64, data: &Path) -> Result<()> {
    if ground == Ground::Smooth && rim == RimFault::None {
        return Ok(());
    }
    let heights = Heights::new(ground, seed, data)?;
    let tiles = read_tiles(folder)?;
    let rings = rings(&tiles);
    for (relative, mesh) in &tiles {
        let height = |p: &DVec3| {
            let z = heights.at(*p);
            rings.get(&position_bits(*p)).map_or(z, |&ring| z + fault_m(rim, ring, *p, seed))
        };
        let new_m: Vec<f64> = mesh.positions.iter().map(height).collect();
        write_heights(&folder.join(relative), &new_m)?;
    }
    rewrite_truth(&folder.join("truth.csv"), &heights)
}

/// The ground of a scene.
struct Heights {
    ground: Ground,
    seed: u64,
    elevation: Option<Elevation>,
}

impl Heights {
    fn new(ground: Ground, seed: u64, data: &Path) -> Result<Self> {
        let elevation = match ground {
            Ground::Elevation => {
                Some(Elevation::read(&data.join("matplotlib-dem/jacksboro_fault_dem.npz"), "elevation.npy")?)
            }
            Ground::Smooth | Ground::Rough => None,
        };
        Ok(Self { ground, seed, elevation })
    }

    /// The height at a place whose height was `p.z`, as a tile of single precision holds it.
    fn at(&self, p: DVec3) -> f64 {
        let z = match (&self.elevation, self.ground) {
            (Some(elevation), _) => elevation.at(p.x / 2.0, p.y / 2.0) / 100.0,
            (None, Ground::Rough) => p.z + short_waves_m(p, self.seed),
            (None, _) => p.z,
        };
        f64::from(z as f32)
    }
}

fn short_waves_m(p: DVec3, seed: u64) -> f64 {
    let wave = |(k, [length_m, amplitude_m]): (usize, [f64; 2])| {
        let turns = |what: i64| unit(hash(&[seed as i64, 0x726f_7567, k as i64, what]));
        let heading = std::f64::consts::TAU * turns(0);
        let along = (p.x * libm::cos(heading) + p.y * libm::sin(heading)) / length_m;
        let across = (p.y * libm::cos(heading) - p.x * libm::sin(heading)) / (1.7 * length_m);
        let tau = std::f64::consts::TAU;
        amplitude_m * libm::sin(tau * (along + turns(1))) * libm::cos(tau * (across + turns(2)))
    };
    SHORT_WAVES.into_iter().enumerate().map(wave).sum()
}

/// Ring of every vertex round a hole: 0 on the rim, 1 behind it. Looked up only, never walked.
fn rings(tiles: &Tiles) -> HashMap<[u64; 3], u8> {
    let mut rings: HashMap<[u64; 3], u8> =
        rim_positions(tiles).into_iter().map(|p| (position_bits(p), 0)).collect();
    for mesh in tiles.values() {
        for triangle in &mesh.triangles {
            let places = triangle.map(|v| position_bits(mesh.positions[v as usize]));
            if places.iter().any(|p| rings.get(p) == Some(&0)) {
                places.into_iter().for_each(|p| _ = rings.entry(p).or_insert(1));
            }
        }
    }
    rings
}

/// How much a vertex of a ring is off: the same in every tile that has it.
fn fault_m(fault: RimFault, ring: u8, p: DVec3, seed: u64) -> f64 {
    let [x, y, _] = position_bits(p);
    let fraction = |what: i64| unit(hash(&[seed as i64, 0x6661_756c, x as i64, y as i64, what]));
    match fault {
        RimFault::None => 0.0,
        RimFault::Noise(sigma_m) => {
            // Twelve evenly spread numbers make a normal one.
            sigma_m * ((0..12).map(fraction).sum::<f64>() - 6.0)
        }
        RimFault::Curl(rise_m) => rise_m / f64::from(1 + u32::from(ring)),
        RimFault::Outliers(share) if fraction(0) < share => {
            let off_m = OUTLIER_M[0] + (OUTLIER_M[1] - OUTLIER_M[0]) * fraction(1);
            if fraction(2) < 0.5 { -off_m } else { off_m }
        }
        RimFault::Outliers(_) => 0.0,
    }
}

/// Bytes of a vertex: three single-precision numbers.
const ROW: usize = 12;

fn write_heights(path: &Path, heights_m: &[f64]) -> Result<()> {
    let name = || path.display().to_string();
    let mut bytes = std::fs::read(path).with_context(name)?;
    let end = b"end_header\n";
    let Some(start) = bytes.windows(end.len()).position(|w| w == end).map(|k| k + end.len()) else {
        bail!("{}: no PLY header", name());
    };
    if bytes.len() < start + ROW * heights_m.len() {
        bail!("{}: shorter than its vertices", name());
    }
    for (row, z) in bytes[start..].chunks_exact_mut(ROW).zip(heights_m) {
        row[8..].copy_from_slice(&(*z as f32).to_le_bytes());
    }
    std::fs::write(path, bytes).with_context(name)
}

fn rewrite_truth(path: &Path, heights: &Heights) -> Result<()> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let mut lines = text.lines();
    let mut new = format!("{}\n", lines.next().unwrap_or_default());
    for line in lines {
        let mut fields = line.splitn(4, ',');
        let mut number = || fields.next().unwrap_or_default().parse::<f64>();
        let p = DVec3::new(number()?, number()?, number()?);
        let rest = fields.next().unwrap_or_default();
        new += &format!("{},{},{},{rest}\n", p.x, p.y, heights.at(p));
    }
    std::fs::write(path, new).with_context(|| path.display().to_string())
}
