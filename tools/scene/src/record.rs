//! What is known of a scene: `scene.json` (grid, holes, classes) and `truth.csv` (the vertices that holes took).

use crate::area::Cell;
use crate::class::Class;
use crate::lattice::UNITS_PER_M;
use crate::make::{MakeError, Summary, io_error};
use crate::maker::{CutOption, Maker};
use crate::shape::Place;
use crate::tile::{CellScene, Lost};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Collects the record while cells are made.
pub(crate) struct Record {
    truth_path: PathBuf,
    truth: BufWriter<File>,
    cells: Vec<CellRecord>,
    pieces: Vec<BTreeMap<Cell, PieceRecord>>,
    lost: Vec<u64>,
}

#[derive(Serialize)]
struct SceneRecord<'a> {
    name: &'a str,
    format: &'a str,
    seed: u64,
    origin: [f64; 3],
    cell: f64,
    nx: i64,
    ny: i64,
    step: f64,
    quantum: f64,
    border_mode: &'a str,
    #[serde(skip_serializing_if = "is_zero")]
    overrun: f64,
    triangles: u64,
    tiles: usize,
    bytes: u64,
    kinds: BTreeMap<String, usize>,
    holes: Vec<HoleRecord<'a>>,
    cells: &'a [CellRecord],
}

#[derive(Serialize)]
struct HoleRecord<'a> {
    id: &'a str,
    area: f64,
    truth_vertices: u64,
    cells: BTreeMap<String, String>,
    removed: BTreeMap<String, PieceRecord>,
    polygons: Vec<Outline>,
    islands: Vec<Vec<Place>>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outline {
    Polygon(Vec<Place>),
    WholeCells(&'static str),
}

#[derive(Clone, Serialize)]
struct PieceRecord {
    triangles: usize,
    area: f64,
    #[serde(skip)]
    class: Option<Class>,
}

#[derive(Serialize)]
struct CellRecord {
    i: i64,
    j: i64,
    tile: Option<String>,
    vertices: usize,
    triangles: usize,
    bytes: u64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Record {
    /// Opens `truth.csv`.
    pub(crate) fn start(maker: &Maker, out: &Path) -> Result<Self, MakeError> {
        let truth_path = out.join("truth.csv");
        let mut truth = BufWriter::new(File::create(&truth_path).map_err(|e| io_error(&truth_path, e))?);
        writeln!(truth, "x,y,z,hole,border").map_err(|e| io_error(&truth_path, e))?;
        let holes = maker.plan().holes.len();
        let (pieces, lost) = (vec![BTreeMap::new(); holes], vec![0; holes]);
        Ok(Self { truth_path, truth, cells: Vec::new(), pieces, lost })
    }

    /// Adds a finished cell whose file has so many bytes (0: no file).
    pub(crate) fn add(&mut self, maker: &Maker, scene: &CellScene, bytes: u64) -> Result<(), MakeError> {
        let [i, j] = maker.frame().cell(scene.cell);
        let tile = (bytes > 0).then(|| maker.tile_name(scene.cell));
        let (vertices, triangles) = (scene.tile.vertices.len(), scene.tile.triangles.len());
        self.cells.push(CellRecord { i, j, tile, vertices, triangles, bytes });
        for piece in &scene.pieces {
            let area = piece.doubled_area as f64 / 2.0 / (UNITS_PER_M * UNITS_PER_M);
            let record = PieceRecord { triangles: piece.triangles, area, class: Some(piece.class) };
            self.pieces[piece.hole as usize].insert([i, j], record);
        }
        for lost in &scene.lost {
            self.lost[lost.hole as usize] += 1;
            write_lost(&mut self.truth, maker, lost).map_err(|e| io_error(&self.truth_path, e))?;
        }
        Ok(())
    }

    /// Writes `scene.json`.
    pub(crate) fn finish(mut self, maker: &Maker, summary: &Summary, out: &Path) -> Result<(), MakeError> {
        self.truth.flush().map_err(|e| io_error(&self.truth_path, e))?;
        self.cells.sort_by_key(|c| [c.j, c.i]);
        let path = out.join("scene.json");
        let file = BufWriter::new(File::create(&path).map_err(|e| io_error(&path, e))?);
        serde_json::to_writer(file, &self.scene(maker, summary)).map_err(|e| io_error(&path, e.into()))
    }

    fn scene<'a>(&'a self, maker: &'a Maker, summary: &Summary) -> SceneRecord<'a> {
        let (plan, options) = (maker.plan(), maker.options());
        let [nx, ny] = maker.frame().turned_size();
        let quads = ((maker.triangles_per_cell() / 2) as f64).sqrt();
        SceneRecord {
            name: plan.name,
            format: options.format.extension(),
            seed: options.seed,
            origin: [options.shift_m[0], options.shift_m[1], 0.0],
            cell: plan.cell_size_m,
            nx,
            ny,
            step: plan.cell_size_m / quads,
            quantum: 1.0 / UNITS_PER_M,
            border_mode: match options.cut {
                CutOption::Exact => "exact",
                CutOption::Overrun(_) => "overrun",
                CutOption::Ragged(_) => "ragged",
            },
            overrun: maker.overrun_m(),
            triangles: summary.triangles,
            tiles: summary.tiles,
            bytes: summary.bytes,
            kinds: summary.counts.iter().map(|(class, n)| (class.to_string(), *n)).collect(),
            holes: (0..plan.holes.len()).map(|k| self.hole(maker, k)).collect(),
            cells: &self.cells,
        }
    }

    fn hole<'a>(&'a self, maker: &'a Maker, k: usize) -> HoleRecord<'a> {
        let hole = &maker.plan().holes[k];
        let pieces = &self.pieces[k];
        let key = |cell: &Cell| format!("{},{}", cell[0], cell[1]);
        let class = |p: &PieceRecord| p.class.map(|c| c.to_string()).unwrap_or_default();
        let outline =
            |ring: Vec<Place>| -> Vec<Place> { ring.into_iter().map(|p| in_scene(maker, p)).collect() };
        let mut polygons: Vec<Outline> =
            hole.parts.iter().map(|s| Outline::Polygon(outline(s.outline()))).collect();
        if !hole.hollow.is_empty() {
            polygons.push(Outline::WholeCells("cells"));
        }
        HoleRecord {
            id: &hole.id,
            area: pieces.values().map(|p| p.area).sum(),
            truth_vertices: self.lost[k],
            cells: pieces.iter().map(|(cell, p)| (key(cell), class(p))).collect(),
            removed: pieces.iter().map(|(cell, p)| (key(cell), p.clone())).collect(),
            polygons,
            islands: hole.islands.iter().map(|s| outline(s.outline())).collect(),
        }
    }
}

/// A planned place as it lies in the files, rounded to a millimetre: outlines are for people and maps.
fn in_scene(maker: &Maker, place: Place) -> Place {
    let [x, y] = maker.frame().place(place, maker.plan().cell_size_m);
    let shift = maker.options().shift_m;
    [x + shift[0], y + shift[1]].map(|k| (k * 1000.0).round() / 1000.0)
}

fn write_lost(truth: &mut impl Write, maker: &Maker, lost: &Lost) -> std::io::Result<()> {
    let [x, y, z] = maker.frame().position(lost.position).map(|k| k as f64 / UNITS_PER_M);
    let shift = maker.options().shift_m;
    writeln!(truth, "{},{},{z},{},{}", x + shift[0], y + shift[1], lost.hole, u8::from(lost.on_edge))
}
