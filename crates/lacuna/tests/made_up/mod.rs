//! A made-up run: three rows of four cells, one hole of every kind, one failure, hostile names.

use glam::DVec3;
use lacuna::report::{
    CellDrawing, CellStatus, ClusterDrawing, ClusterRecord, DefectRecord, Drawing, Execution, HeightRaster,
    HoleClass, HoleDrawing, HoleRecord, HoleShape, Outcome, REPORT_VERSION, Report, SceneRecord, SeamRecord,
    StageRecord, Summary,
};
use lacuna_mesh::Bounds;
use serde_json::json;
use std::collections::BTreeMap;

const CELL_M: f64 = 250.0;

/// Name of a tile that tries to break out of the page and of the terminal.
pub(crate) const HOSTILE: &str = "<script>alert(1)</script>\u{1b}[31m\"'&";

/// Cluster, cell, class, shape, layer, place in the cell (shares), outcome.
type Row = (&'static str, [i32; 2], HoleClass, Option<HoleShape>, u32, [f64; 4], Outcome);

fn rows() -> Vec<Row> {
    use HoleClass::{Closed, External, Internal};
    use HoleShape::{A, B, C, D};
    use Outcome::{Failed, Filled, Skipped};
    vec![
        ("84120_446060", [0, 0], Closed, None, 1, [0.4, 0.2, 0.55, 0.4], Filled),
        ("84510_446290", [1, 0], Internal, Some(B), 1, [0.3, 0.5, 0.9, 1.0], Filled),
        ("84510_446290", [1, 1], Internal, Some(C), 2, [0.2, 0.0, 1.0, 0.8], Filled),
        ("84510_446290", [2, 1], Internal, Some(A), 1, [0.0, 0.0, 1.0, 1.0], Filled),
        ("84510_446290", [2, 2], Internal, Some(D), 1, [0.1, 0.0, 0.9, 0.6], Filled),
        ("84990_446100", [3, 0], External, Some(B), 1, [0.5, 0.2, 1.0, 0.7], Skipped),
        ("84930_446640", [3, 2], Closed, None, 1, [0.2, 0.3, 0.4, 0.5], Failed),
        ("84020_446600", [0, 2], Closed, None, 1, [0.1, 0.4, 0.105, 0.41], Filled),
    ]
}

fn tile(cell: [i32; 2]) -> String {
    if cell == [3, 2] { HOSTILE.to_owned() } else { format!("Tile_+00{}_+00{}", cell[0], cell[1]) }
}

/// The report of the made-up run.
pub(crate) fn report() -> Report {
    let holes: Vec<HoleRecord> = rows().iter().map(hole).collect();
    Report {
        version: REPORT_VERSION,
        lacuna: "0.1.0".to_owned(),
        method: "layered".to_owned(),
        threads: 2,
        memory_limit_bytes: 12 << 30,
        peak_rss_bytes: 1_503_238_553,
        scene: SceneRecord {
            cells: 12,
            triangles: 1_234_567,
            bytes: 8_123_456_789,
            cell_size_m: CELL_M,
            origin_m: [0.0, -0.000_04],
            border_mode: "overrun".to_owned(),
            overrun_m: Some(0.100_04),
            format: "OBJ".to_owned(),
            srs: Some("EPSG:28992".to_owned()),
            srs_origin: Some([84_000.0, 446_000.0, 0.0]),
        },
        stages: vec![
            stage("scan", 6.25, 0.4),
            stage("plan", 0.031_249, 0.4),
            stage("fill", 93.4, 1.4),
            stage("write", 12.0, 0.9),
        ],
        clusters: clusters(&holes),
        summary: Summary::from_holes(&holes),
        holes,
        seams: SeamRecord {
            borders: 3,
            shared_vertices: 412,
            differing_vertices: 0,
            max_gap_m: 0.000_000_49,
        },
        configuration: json!({"fill": {"method": "layered", "spacing_m": null}, "note": "</pre><script>"}),
        not_holes: BTreeMap::from([("passage".to_owned(), 2), ("seam_of_sub_blocks".to_owned(), 7)]),
        defects: vec![DefectRecord {
            tile: "Tile_+001_+002".to_owned(),
            what: "3 triangles without area".to_owned(),
            unusable: false,
        }],
        warnings: vec!["cells of 250 m were inferred".to_owned()],
        changed_tiles: vec!["Tile_+000_+000.obj".to_owned(), "Tile_+001_+000.obj".to_owned()],
        execution: Execution {
            scene: "deliveries/oosterhaven_v2/".to_owned(),
            output: "out".to_owned(),
            ..Execution::default()
        },
    }
}

fn stage(name: &str, seconds: f64, memory_gib: f64) -> StageRecord {
    let peak_rss_bytes = (memory_gib * f64::from(1 << 30)) as u64;
    StageRecord { name: name.to_owned(), seconds, cpu_seconds: 1.7 * seconds, peak_rss_bytes }
}

fn hole(&(cluster, cell, class, shape, layer, place, outcome): &Row) -> HoleRecord {
    let (width, height) = ((place[2] - place[0]) * CELL_M, (place[3] - place[1]) * CELL_M);
    let is_filled = outcome == Outcome::Filled;
    HoleRecord {
        id: format!("{cluster}/{}", tile(cell)),
        cluster: cluster.to_owned(),
        tile: tile(cell),
        cell,
        class,
        shape,
        layer,
        area_m2: width * height,
        perimeter_m: 2.0 * (width + height),
        rim_vertices: 37,
        islands_passed_under: 0,
        outcome,
        reason: reason(outcome),
        method: is_filled.then(|| "layered".to_owned()),
        filler: is_filled.then(|| "delaunay".to_owned()),
        patch_vertices: if is_filled { 120 } else { 0 },
        patch_triangles: if is_filled { 275 } else { 0 },
        quality_mean: is_filled.then_some(0.912_345_678_9),
        quality_share_good: is_filled.then_some(if layer == 2 { 0.81 } else { 0.985 }),
    }
}

fn reason(outcome: Outcome) -> Option<String> {
    match outcome {
        Outcome::Filled => None,
        Outcome::Skipped => {
            Some("at the edge of the reconstruction area; --external fill fills it".to_owned())
        }
        Outcome::Failed => {
            Some("its rim crosses itself at 84930.2, 446640.9 and no triangulation joins it <b>".to_owned())
        }
    }
}

fn clusters(holes: &[HoleRecord]) -> Vec<ClusterRecord> {
    let mut clusters: Vec<ClusterRecord> = Vec::new();
    for hole in holes {
        if let Some(cluster) = clusters.iter_mut().find(|c| c.id == hole.cluster) {
            cluster.tiles.push(hole.tile.clone());
            cluster.area_m2 += hole.area_m2;
            cluster.layers = cluster.layers.max(hole.layer);
            continue;
        }
        let (x, y) = hole.cluster.split_once('_').expect("an id of two numbers");
        clusters.push(ClusterRecord {
            id: hole.cluster.clone(),
            x: x.parse().expect("a number"),
            y: y.parse().expect("a number"),
            tiles: vec![hole.tile.clone()],
            area_m2: hole.area_m2,
            layers: hole.layer,
            level_m: None,
            level_support: None,
            level_residual_m: None,
            outcome: hole.outcome,
            reason: hole.reason.clone(),
        });
    }
    clusters
}

/// Its shapes; `with_hillshade` adds a hilly ground with the holes cut out before, and whole after.
pub(crate) fn drawing(with_hillshade: bool) -> Drawing {
    let rect = |cell: [i32; 2]| {
        let (x, y) = (f64::from(cell[0]) * CELL_M, f64::from(cell[1]) * CELL_M);
        [x, y, x + CELL_M, y + CELL_M]
    };
    let cells = (0..12).map(|k| {
        let index = [k % 4, k / 4];
        let status = match index {
            [0, 1] => CellStatus::Untouched,
            [1, 2] => CellStatus::Failed,
            [2, 1] => CellStatus::Missing,
            _ if rows().iter().any(|r| r.1 == index && r.6 == Outcome::Filled) => CellStatus::Repaired,
            _ => CellStatus::Untouched,
        };
        CellDrawing { index, rect: rect(index), tile: tile(index), status }
    });
    let holes = rows().into_iter().map(|(cluster, cell, class, shape, layer, place, outcome)| HoleDrawing {
        id: format!("{cluster}/{}", tile(cell)),
        class,
        shape,
        layer,
        rings: outline(rect(cell), place, shape == Some(HoleShape::D)),
        passed_under: vec![],
        outcome,
    });
    let lake =
        vec![[325.0, 125.0], [475.0, 125.0], [750.0, 250.0], [750.0, 650.0], [525.0, 650.0], [300.0, 450.0]];
    let raster = |cut| with_hillshade.then(|| hills(cut));
    Drawing {
        cells: cells.collect(),
        holes: holes.collect(),
        clusters: vec![ClusterDrawing { id: "84510_446290".to_owned(), rings: vec![lake] }],
        before: raster(true),
        after: raster(false),
    }
}

fn outline(cell: [f64; 4], place: [f64; 4], has_island: bool) -> Vec<Vec<[f64; 2]>> {
    let at = |u: f64, v: f64| [cell[0] + u * CELL_M, cell[1] + v * CELL_M];
    let [u0, v0, u1, v1] = place;
    let (um, vm) = ((u0 + u1) / 2.0, (v0 + v1) / 2.0);
    let mut rings = vec![vec![at(u0, v0), at(um, v0), at(u1, v0), at(u1, v1), at(um, v1), at(u0, vm)]];
    if has_island {
        rings.push(vec![at(um, vm), at(um, vm + 0.1), at(um + 0.1, vm + 0.1), at(um + 0.1, vm)]);
    }
    rings
}

fn hills(cut: bool) -> HeightRaster {
    let height = |x: f64, y: f64| 14.0 * (x / 71.0).sin() * (y / 53.0).cos() + 5.0 * ((x + y) / 23.0).sin();
    let bounds = Bounds { min: DVec3::new(0.0, 0.0, -20.0), max: DVec3::new(1000.0, 750.0, 20.0) };
    let mut raster = HeightRaster::new(&bounds, 2.0);
    let is_hole = |x: f64, y: f64| {
        rows().iter().any(|row| {
            let (u, v) = (x / CELL_M - f64::from(row.1[0]), y / CELL_M - f64::from(row.1[1]));
            (row.5[0]..row.5[2]).contains(&u) && (row.5[1]..row.5[3]).contains(&v)
        })
    };
    for k in 0..200 * 150 {
        let (x, y) = (f64::from(k % 200) * 5.0, f64::from(k / 200) * 5.0);
        if cut && is_hole(x + 2.5, y + 2.5) {
            continue;
        }
        let corner = |dx: f64, dy: f64| DVec3::new(x + dx, y + dy, height(x + dx, y + dy));
        let square = [corner(0.0, 0.0), corner(5.0, 0.0), corner(5.0, 5.0), corner(0.0, 5.0)];
        raster.add_triangles(&square, &[[0, 1, 2], [0, 2, 3]]);
    }
    raster
}
