//! Which pictures a result has: time and memory against area, memory over time, speed against threads.

use super::chart::{Chart, Curve, Scale};
use super::result::{BenchResult, Row, RowOutcome};

const MIB: f64 = (1_u64 << 20) as f64;

/// Name and text of every picture.
pub(super) fn pictures(result: &BenchResult) -> Vec<(String, String)> {
    result.series().into_iter().flat_map(|series| of_series(result, series)).collect()
}

fn of_series(result: &BenchResult, series: &str) -> Vec<(String, String)> {
    let rows: Vec<&Row> = result.rows.iter().filter(|r| r.series == series).collect();
    let mut all = Vec::new();
    let mut add = |what: &str, svg: Option<String>| {
        all.extend(svg.map(|svg| (format!("{series}_{what}.svg"), svg)));
    };
    if distinct(rows.iter().map(|r| r.scene.as_str())).len() > 1 {
        let limit = limit_of(&rows);
        let time = against_area(result, &rows, |r| r.wall_s.map(|d| d.median));
        add("time", chart(&format!("{series}: time against area"), ["km2", "seconds"], time, None));
        let memory = against_area(result, &rows, |r| r.peak_rss_bytes.map(|b| b as f64 / MIB));
        add("memory", chart(&format!("{series}: peak memory against area"), ["km2", "MiB"], memory, limit));
    }
    if let Some(largest) = largest_scene(result, &rows) {
        let of_it: Vec<&Row> = rows.iter().copied().filter(|r| r.scene == largest).collect();
        add("memory_over_time", memory_over_time(series, &of_it));
        add("threads", threads(series, &of_it));
    }
    all
}

fn chart(title: &str, axes: [&str; 2], curves: Vec<Curve>, limit: Option<f64>) -> Option<String> {
    let limit = limit.map(|level| ("limit of the methods", level));
    Chart { title, axes, scales: [Scale::Logarithmic; 2], curves, limit }.to_svg()
}

/// Values without repeats, in their order.
fn distinct<'a, T: PartialEq + 'a>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut kept = Vec::new();
    for value in values {
        if !kept.contains(&value) {
            kept.push(value);
        }
    }
    kept
}

fn limit_of(rows: &[&Row]) -> Option<f64> {
    rows.iter().filter_map(|r| r.memory_limit_bytes).max().map(|b| b as f64 / MIB)
}

/// A name for every method, with the threads where a method runs with several numbers of them.
fn name(rows: &[&Row], row: &Row) -> String {
    let has_several = rows.iter().any(|r| r.method == row.method && r.threads != row.threads);
    if has_several { format!("{} -j {}", row.method, row.threads) } else { row.method.clone() }
}

fn against_area(result: &BenchResult, rows: &[&Row], value: impl Fn(&Row) -> Option<f64>) -> Vec<Curve> {
    let curve = |curve_name: String| {
        let of_it = rows.iter().filter(|r| r.outcome == RowOutcome::Done && name(rows, r) == curve_name);
        let mut points: Vec<[f64; 2]> =
            of_it.filter_map(|r| Some([result.scene_of(r)?.area_km2, value(r)?])).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Curve { name: curve_name, points, has_marks: true }
    };
    distinct(rows.iter().map(|r| name(rows, r))).into_iter().map(curve).collect()
}

fn largest_scene<'a>(result: &'a BenchResult, rows: &[&'a Row]) -> Option<&'a str> {
    let scenes = rows.iter().filter_map(|r| result.scene_of(r));
    scenes.max_by_key(|s| s.triangles).map(|s| s.name.as_str())
}

/// Only repairs: a copy holds nothing worth a picture.
fn memory_over_time(series: &str, rows: &[&Row]) -> Option<String> {
    let repairs: Vec<&Row> = rows.iter().copied().filter(|r| r.memory_limit_bytes.is_some()).collect();
    let curve = |row: &&Row| Curve {
        name: name(&repairs, row),
        points: row.samples.iter().map(|s| [s.at_s, s.rss_bytes as f64 / MIB]).collect(),
        has_marks: false,
    };
    Chart {
        title: &format!("{series}: memory over time, largest scene"),
        axes: ["seconds", "MiB"],
        scales: [Scale::Linear; 2],
        curves: repairs.iter().map(curve).collect(),
        limit: limit_of(&repairs).map(|level| ("limit", level)),
    }
    .to_svg()
}

/// How many times as fast as with the fewest threads, where there are several numbers of them.
fn threads(series: &str, rows: &[&Row]) -> Option<String> {
    let curve = |method: &str| {
        let mut of_it: Vec<(usize, f64)> = rows
            .iter()
            .filter(|r| r.method == method && r.outcome == RowOutcome::Done)
            .filter_map(|r| Some((r.threads, r.wall_s?.median)))
            .collect();
        of_it.sort_by_key(|(threads, _)| *threads);
        let first_s = of_it.first().map_or(0.0, |(_, seconds)| *seconds);
        let points = of_it.iter().map(|(threads, seconds)| [*threads as f64, first_s / seconds]).collect();
        Curve { name: method.to_owned(), points, has_marks: true }
    };
    let curves: Vec<Curve> = distinct(rows.iter().map(|r| r.method.as_str()))
        .into_iter()
        .map(curve)
        .filter(|c| c.points.len() > 1)
        .collect();
    let title = format!("{series}: speed against threads, largest scene");
    let axes = ["threads", "times as fast as with the fewest"];
    Chart { title: &title, axes, scales: [Scale::Linear; 2], curves, limit: None }.to_svg()
}
