//! Digs discs into an existing scene and keeps what was taken as truth.
//!
//! Faces whose centroid lies in a disc (seen from above, z up) are taken out of PLY (binary) and OBJ tiles; every other
//! byte stays, but the face count in a PLY header. Rims are as they come: this is how holes in real tiles look. One tile
//! is in memory at a time.

mod discs;
mod faces;
mod files;
mod obj;
mod ply;

pub use discs::Disc;

use discs::{TileSketch, choose};
use faces::TileFaces;
use serde::Serialize;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Where to dig.
#[derive(Clone, Debug)]
pub struct DigOptions {
    /// How many discs.
    pub discs: usize,
    /// Smallest and largest radius, metres.
    pub radius_m: [f64; 2],
    /// Centres on borders between tiles instead of inside tiles.
    pub across_borders: bool,
    /// Seed of places and radii.
    pub seed: u64,
}

/// What was dug.
#[derive(Clone, Debug, PartialEq)]
pub struct DigSummary {
    /// Tiles that lost faces.
    pub changed_tiles: usize,
    /// Tiles in all.
    pub tiles: usize,
    /// Faces taken, disc by disc.
    pub removed: Vec<usize>,
    /// Vertices that no face uses any more.
    pub lost_vertices: usize,
}

/// Why nothing was dug.
#[derive(Debug, thiserror::Error)]
pub enum DigError {
    /// No tile in the folder.
    #[error("{}: no .ply or .obj tile in this folder", .0.display())]
    NoTiles(PathBuf),
    /// OUT would be mixed with other files, or lies in SCENE.
    #[error("{}: give a new or empty folder outside the scene", .0.display())]
    BadOut(PathBuf),
    /// A tile that can't be read.
    #[error("{}: {problem}", path.display())]
    Tile {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A file that can't be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Radii that make no sense.
    #[error("radius {from_m},{to_m}: give two lengths in metres, 0 < A <= B")]
    Radius {
        /// Smallest, metres.
        from_m: f64,
        /// Largest, metres.
        to_m: f64,
    },
    /// Not all discs found a place.
    #[error("only {found} of {wanted} discs found room: take fewer --discs or a smaller --radius")]
    NoRoom {
        /// Discs placed.
        found: usize,
        /// Discs asked for.
        wanted: usize,
    },
}

#[derive(Serialize)]
struct HoleRecord {
    id: String,
    centre: [f64; 2],
    radius_m: f64,
    faces: usize,
    area_m2: f64,
    tiles: Vec<String>,
}

/// Copies the scene to `out` with holes: chooses places from a sketch of all tiles, then rewrites tile by tile, and
/// writes `scene.json` (the discs) and `truth.csv` (`x,y,z,hole` of every vertex that no face of its tile uses any more: a
/// border vertex that two tiles have is judged in each of them).
///
/// # Errors
/// See [`DigError`]; the scene itself is never written to.
pub fn dig(scene: &Path, out: &Path, options: &DigOptions) -> Result<DigSummary, DigError> {
    let [from_m, to_m] = options.radius_m;
    if !(from_m > 0.0 && from_m <= to_m && to_m.is_finite()) {
        return Err(DigError::Radius { from_m, to_m });
    }
    files::claim_out(scene, out)?;
    let (tiles, others) = files::list(scene)?;
    if tiles.is_empty() {
        return Err(DigError::NoTiles(scene.into()));
    }
    let sketches = sketch_all(scene, &tiles, options.seed)?;
    let discs = choose(&sketches, options)?;
    for file in &others {
        files::write(&out.join(file), &files::read(&scene.join(file))?)?;
    }
    let mut excavation = Excavation::start(out, &discs)?;
    for tile in &tiles {
        excavation.dig_tile(scene, out, tile)?;
    }
    excavation.finish(out, tiles.len())
}

fn sketch_all(scene: &Path, tiles: &[PathBuf], seed: u64) -> Result<Vec<TileSketch>, DigError> {
    let sketch = |(number, tile): (usize, &PathBuf)| {
        let path = scene.join(tile);
        let faces = read_faces(&path, &files::read(&path)?)?;
        Ok(TileSketch::of(&faces, &[seed as i64, number as i64]))
    };
    tiles.iter().enumerate().map(sketch).collect()
}

fn read_faces(path: &Path, bytes: &[u8]) -> Result<TileFaces, DigError> {
    let is_ply = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    let faces = if is_ply { ply::read(bytes) } else { obj::read(bytes) };
    faces.map_err(|problem| DigError::Tile { path: path.into(), problem })
}

/// The discs with what each took so far.
struct Excavation<'a> {
    discs: &'a [Disc],
    holes: Vec<HoleRecord>,
    truth: BufWriter<std::fs::File>,
    truth_path: PathBuf,
    changed_tiles: usize,
    lost_vertices: usize,
}

impl<'a> Excavation<'a> {
    fn start(out: &Path, discs: &'a [Disc]) -> Result<Self, DigError> {
        let truth_path = out.join("truth.csv");
        let file = std::fs::File::create(&truth_path).map_err(|e| files::io_error(&truth_path, e))?;
        let mut truth = BufWriter::new(file);
        writeln!(truth, "x,y,z,hole").map_err(|e| files::io_error(&truth_path, e))?;
        let hole = |(k, disc): (usize, &Disc)| HoleRecord {
            id: format!("disc_{:03}", k + 1),
            centre: disc.centre,
            radius_m: disc.radius_m,
            faces: 0,
            area_m2: 0.0,
            tiles: Vec::new(),
        };
        let holes = discs.iter().enumerate().map(hole).collect();
        Ok(Self { discs, holes, truth, truth_path, changed_tiles: 0, lost_vertices: 0 })
    }

    fn dig_tile(&mut self, scene: &Path, out: &Path, tile: &Path) -> Result<(), DigError> {
        let bytes = files::read(&scene.join(tile))?;
        let faces = read_faces(&scene.join(tile), &bytes)?;
        let hole_of: Vec<Option<usize>> = (0..faces.len()).map(|f| self.disc_at(&faces, f)).collect();
        if hole_of.iter().all(Option::is_none) {
            return files::write(&out.join(tile), &bytes);
        }
        self.changed_tiles += 1;
        self.note_faces(&faces, &hole_of, tile);
        self.note_lost(&faces, &hole_of)?;
        files::write(&out.join(tile), &faces.without(&bytes, |f| hole_of[f].is_some()))
    }

    fn disc_at(&self, faces: &TileFaces, face: usize) -> Option<usize> {
        let [x, y, _] = faces.centroid(face)?;
        self.discs.iter().position(|d| d.contains([x, y]))
    }

    fn note_faces(&mut self, faces: &TileFaces, hole_of: &[Option<usize>], tile: &Path) {
        let name = tile.to_string_lossy().into_owned();
        for (face, hole) in hole_of.iter().enumerate().filter_map(|(f, h)| Some((f, (*h)?))) {
            let record = &mut self.holes[hole];
            record.faces += 1;
            record.area_m2 += faces.plan_area(face);
            if record.tiles.last() != Some(&name) {
                record.tiles.push(name.clone());
            }
        }
    }

    fn note_lost(&mut self, faces: &TileFaces, hole_of: &[Option<usize>]) -> Result<(), DigError> {
        for (vertex, hole) in faces.lost_vertices(hole_of) {
            let [x, y, z] = faces.positions[vertex];
            writeln!(self.truth, "{x},{y},{z},{hole}").map_err(|e| files::io_error(&self.truth_path, e))?;
            self.lost_vertices += 1;
        }
        Ok(())
    }

    fn finish(mut self, out: &Path, tiles: usize) -> Result<DigSummary, DigError> {
        self.truth.flush().map_err(|e| files::io_error(&self.truth_path, e))?;
        let path = out.join("scene.json");
        let json = serde_json::json!({ "name": "dug", "holes": self.holes });
        files::write(&path, json.to_string().as_bytes())?;
        let removed = self.holes.iter().map(|h| h.faces).collect();
        Ok(DigSummary {
            changed_tiles: self.changed_tiles,
            tiles,
            removed,
            lost_vertices: self.lost_vertices,
        })
    }
}
