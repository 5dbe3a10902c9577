//! SVG pictures: a section through a hole, a map of the errors, error against depth.

use crate::locate::Locator;
use crate::measure::Repaired;
use crate::scene_files::TruthPoint;
use glam::DVec2;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Size of a chart, and its margin.
const SIZE: [f64; 2] = [640.0, 300.0];
const MARGIN: f64 = 44.0;
/// Colours of curves by name, the same in every picture; those of others in the order of the legend.
const NAMED: [(&str, &str); 4] =
    [("truth", "#57606a"), ("field", "#1f6feb"), ("layered", "#d29922"), ("aggregate", "#cf222e")];
const OTHERS: [&str; 3] = ["#1a7f37", "#8250df", "#bf3989"];

/// A named curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What the legend calls it.
    pub name: String,
    /// Points; a gap where the height is not finite.
    pub points: Vec<[f64; 2]>,
}

/// The colour of the curve at place `k` of a legend.
fn colour(name: &str, k: usize) -> &'static str {
    NAMED.iter().find(|n| n.0 == name).map_or(OTHERS[k % OTHERS.len()], |n| n.1)
}

/// A chart of some curves over a common x axis; the y axis begins at `floor` if that is given.
#[must_use]
pub fn chart(title: &str, axes: [&str; 2], floor: Option<f64>, curves: &[Curve]) -> String {
    let all = || curves.iter().flat_map(|c| &c.points).filter(|p| p[1].is_finite());
    let range =
        |k: usize| all().fold([f64::INFINITY, f64::NEG_INFINITY], |r, p| [r[0].min(p[k]), r[1].max(p[k])]);
    let (x, mut y) = (range(0), range(1));
    y[0] = floor.unwrap_or(y[0]);
    let across = |v: f64| MARGIN + (v - x[0]) / (x[1] - x[0]).max(1e-9) * (SIZE[0] - 2.0 * MARGIN);
    let up = |v: f64| SIZE[1] - MARGIN - (v - y[0]) / (y[1] - y[0]).max(1e-9) * (SIZE[1] - 2.0 * MARGIN);
    let mut svg = start(SIZE, title);
    let (left, right, low, high) = (MARGIN, SIZE[0] - MARGIN, SIZE[1] - MARGIN, MARGIN);
    let _ = writeln!(svg, "<path d=\"M{left} {high}V{low}H{right}\" fill=\"none\" stroke=\"#57606a\"/>");
    for (text, px, py, anchor) in [
        (decimal(x[0]), left, low + 14.0, "start"),
        (format!("{} {}", decimal(x[1]), axes[0]), right, low + 14.0, "end"),
        (decimal(y[0]), left - 4.0, low, "end"),
        (decimal(y[1]), left - 4.0, high + 4.0, "end"),
        (axes[1].to_owned(), left, high - 6.0, "start"),
    ] {
        let _ = writeln!(svg, "<text x=\"{px}\" y=\"{py}\" text-anchor=\"{anchor}\">{text}</text>");
    }
    for (k, curve) in curves.iter().enumerate() {
        let colour = colour(&curve.name, k);
        let mut path = String::new();
        let mut pen = 'M';
        for p in &curve.points {
            if p[1].is_finite() {
                let _ = write!(path, "{pen}{:.1} {:.1}", across(p[0]), up(p[1]));
                pen = 'L';
            } else {
                pen = 'M';
            }
        }
        let _ = writeln!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>");
        let at = MARGIN + 110.0 * k as f64;
        let _ =
            writeln!(svg, "<text x=\"{at}\" y=\"{}\" fill=\"{colour}\">{}</text>", SIZE[1] - 6.0, curve.name);
    }
    svg + "</svg>\n"
}

/// At most two digits behind the point.
fn decimal(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn start(size: [f64; 2], title: &str) -> String {
    let [w, h] = size;
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n\
         <text x=\"{}\" y=\"16\" text-anchor=\"middle\" font-size=\"13\">{title}</text>\n",
        w / 2.0
    )
}

/// A line from west to east through the middle of the hole with most true vertices: its y, and where it starts and ends.
#[must_use]
pub fn section_line(truth: &[TruthPoint]) -> Option<(u32, f64, [f64; 2])> {
    let mut holes: BTreeMap<u32, Vec<DVec2>> = BTreeMap::new();
    truth.iter().for_each(|t| holes.entry(t.hole).or_default().push(t.position.truncate()));
    let (&hole, places) =
        holes.iter().max_by_key(|(hole, places)| (places.len(), std::cmp::Reverse(**hole)))?;
    let middle = places.iter().sum::<DVec2>() / places.len() as f64;
    let low = places.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
    let high = places.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max);
    Some((hole, middle.y, [low, high]))
}

/// Points on a section.
const STEPS: usize = 240;

/// The highest surface of a repaired scene along a section.
#[must_use]
pub fn section(repaired: &Repaired, y: f64, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let margin = 0.1 * (to - from);
    let near = repaired.facets.iter().filter(|f| {
        let ys = f.corners.map(|c| c.y);
        ys.iter().any(|v| *v <= y) && ys.iter().any(|v| *v >= y)
    });
    let locator = Locator::new(near.map(|f| f.corners).collect());
    (0..=STEPS)
        .map(|k| {
            let x = from - margin + (to - from + 2.0 * margin) * k as f64 / STEPS as f64;
            let top = locator.heights(DVec2::new(x, y)).into_iter().fold(f64::NAN, f64::max);
            [x, top]
        })
        .collect()
}

/// True vertices of a hole near the section, from west to east.
#[must_use]
pub fn true_section(truth: &[TruthPoint], hole: u32, y: f64, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let count = truth.iter().filter(|t| t.hole == hole).count();
    let half_m = 0.6 * (to - from) / (count as f64).sqrt();
    let near = |t: &&TruthPoint| t.hole == hole && (t.position.y - y).abs() <= half_m;
    let mut points: Vec<[f64; 2]> = truth.iter().filter(near).map(|t| [t.position.x, t.position.z]).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// Squares of a map along its longer side, and colour classes on each side of 0.
const SQUARES: f64 = 60.0;
const CLASSES: i32 = 4;

/// Maps of the signed error over one hole, side by side: red lies too high, blue too low; the last class begins at `full_m`.
#[must_use]
pub fn error_maps(truth: &[TruthPoint], hole: u32, full_m: f64, maps: &[(&str, &[Option<f64>])]) -> String {
    let places = || truth.iter().filter(|t| t.hole == hole).map(|t| t.position.truncate());
    let low = places().fold(DVec2::INFINITY, DVec2::min);
    let extent = places().fold(DVec2::NEG_INFINITY, DVec2::max) - low;
    let square_m = extent.max_element().max(1e-9) / SQUARES;
    let side = 3.0;
    let width = SQUARES * side + 16.0;
    let title =
        format!("signed error; full red: {:+.0} cm, full blue: {:+.0} cm", 100.0 * full_m, -100.0 * full_m);
    let mut svg = start([width * maps.len() as f64 + 16.0, SQUARES * side + 60.0], &title);
    for (k, (name, errors)) in maps.iter().enumerate() {
        let left = 16.0 + width * k as f64;
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"36\">{name}</text>");
        let mut squares: BTreeMap<(i64, i64), (f64, f64)> = BTreeMap::new();
        for (t, error) in truth.iter().zip(*errors).filter(|(t, _)| t.hole == hole) {
            let place = ((t.position.truncate() - low) / square_m).floor();
            if let Some(error) = error {
                let sum = squares.entry((place.y as i64, place.x as i64)).or_default();
                *sum = (sum.0 + error, sum.1 + 1.0);
            }
        }
        let class_of = |(sum, count): (f64, f64)| {
            ((sum / count / full_m * f64::from(CLASSES)).round() as i32).clamp(-CLASSES, CLASSES)
        };
        let squares: Vec<(i64, i64, i32)> =
            squares.into_iter().map(|((j, i), sum)| (j, i, class_of(sum))).collect();
        let mut classes: BTreeMap<i32, String> = BTreeMap::new();
        // Neighbours of one row and class are one rectangle.
        for run in squares.chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1 && a.2 == b.2) {
            let (j, i, class) = run[0];
            let (x, y) = (left + i as f64 * side, 44.0 + (SQUARES - 1.0 - j as f64) * side);
            let length = side * run.len() as f64;
            let path = classes.entry(class).or_default();
            let _ = write!(path, "M{x:.0} {y:.0}h{length:.0}v3h-{length:.0}z");
        }
        for (class, path) in classes {
            let _ = writeln!(svg, "<path d=\"{path}\" fill=\"{}\"/>", class_colour(class));
        }
    }
    svg + "</svg>\n"
}

fn class_colour(class: i32) -> String {
    let pale = 235 - 235 * class.abs() / CLASSES;
    if class >= 0 { format!("rgb(235,{pale},{pale})") } else { format!("rgb({pale},{pale},235)") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_keep_their_colours_and_break_where_nothing_is_known() {
        let curve = |name: &str| Curve {
            name: name.to_owned(),
            points: vec![[0.0, 1.0], [1.0, 2.0], [2.0, f64::NAN], [3.0, 4.0]],
        };
        let alone = chart("one", ["m", "m"], Some(0.0), &[curve("field")]);
        let after = chart("two", ["m", "m"], None, &[curve("other"), curve("field")]);
        assert!(alone.contains("#1f6feb") && after.contains("#1f6feb") && after.contains(OTHERS[0]));
        let path = alone.lines().find(|l| l.contains("stroke-width")).expect("a curve");
        assert_eq!((path.matches('M').count(), path.matches('L').count()), (2, 1));
    }

    #[test]
    fn a_section_sees_the_highest_surface() {
        let facet = |z: f64| crate::slope::Facet {
            corners: [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]].map(|[x, y]| glam::DVec3::new(x, y, z)),
            tile: 0,
            is_patch: true,
        };
        let repaired = Repaired { facets: vec![facet(1.0), facet(3.0)] };
        let points = section(&repaired, 2.0, [1.0, 9.0]);
        // The triangles end at x = 8 on this line.
        assert!(points.iter().all(|p| p[0] > 7.9 || (p[1] - 3.0).abs() < 1e-9), "{points:?}");
        assert!(points.iter().all(|p| p[0] < 8.1 || p[1].is_nan()), "{points:?}");
    }
}
