//! The map of a run as one SVG: hillshade before and after, cells, clusters, holes.
//!
//! Class is told by colour *and* by the label's ring, shape by its letter, layer by its number, outcome by the stroke
//! (skipped: dashed) and a cross (failed): nothing by colour alone.

use super::base64::base64;
use super::drawing::{CellStatus, Drawing, HoleDrawing};
use super::hillshade::HeightRaster;
use super::model::Outcome;
use std::fmt::Write;

/// Width of the drawing in its own units; the page scales it.
const WIDTH: f64 = 1000.0;

/// Points nearer to the last kept one than this, in drawing units, are left out of outlines.
const TOLERANCE: f64 = 0.2;

/// Holes smaller than this, in drawing units, get a dot, so that they can be seen.
const SMALLEST: f64 = 6.0;

/// Holes smaller than this, in drawing units, get no label.
const LABELLED: f64 = 16.0;

/// From scene coordinates to drawing units, y down.
#[derive(Clone, Copy)]
struct View {
    west_m: f64,
    north_m: f64,
    scale: f64,
    height: f64,
}

/// The SVG element; empty if there is nothing to draw. `title_of` gives a hole's record as one line.
///
/// # Errors
/// The PNG encoder's.
pub(crate) fn map(
    drawing: &Drawing,
    title_of: &dyn Fn(&str) -> String,
) -> Result<String, png::EncodingError> {
    let Some(view) = View::over(drawing) else { return Ok(String::new()) };
    let mut svg = String::new();
    let _ = write!(
        svg,
        "<svg id=\"map\" viewBox=\"0 0 {WIDTH} {:.1}\" role=\"img\" aria-label=\"map of cells and holes\">\n\
         <defs><clipPath id=\"wipe\"><rect id=\"wipe-rect\" x=\"0\" y=\"0\" width=\"{WIDTH}\" height=\"{:.1}\"/></clipPath></defs>\n",
        view.height, view.height
    );
    svg.push_str("<g id=\"ground\">\n");
    image(&mut svg, &view, drawing.before.as_ref(), "before", "")?;
    image(&mut svg, &view, drawing.after.as_ref(), "after", " clip-path=\"url(#wipe)\"")?;
    svg.push_str("</g>\n<g id=\"cells\">\n");
    cells(&mut svg, &view, drawing);
    svg.push_str("</g>\n<g id=\"holes\">\n");
    for cluster in &drawing.clusters {
        let _ = writeln!(svg, "<path class=\"cluster\" d=\"{}\"/>", view.path(&cluster.rings));
    }
    for hole in &drawing.holes {
        draw_hole(&mut svg, &view, hole, &title_of(&hole.id));
    }
    svg.push_str("</g>\n</svg>\n");
    Ok(svg)
}

/// Text as it may stand in an element or an attribute.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            c if c.is_control() => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

impl View {
    /// A view over all cells (over all holes if there is no cell).
    fn over(drawing: &Drawing) -> Option<Self> {
        let corners = drawing.cells.iter().flat_map(|c| [[c.rect[0], c.rect[1]], [c.rect[2], c.rect[3]]]);
        let points = drawing.holes.iter().flat_map(|h| h.rings.iter().flatten().copied());
        let finite = corners.chain(points).filter(|p| p[0].is_finite() && p[1].is_finite());
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in finite {
            for k in 0..2 {
                low[k] = low[k].min(point[k]);
                high[k] = high[k].max(point[k]);
            }
        }
        let (x, y) = (high[0] - low[0], high[1] - low[1]);
        // A strip a hundred times as high as wide still fits on a page.
        let scale = WIDTH / x.max(y / 2.0);
        (scale.is_finite() && scale > 0.0).then(|| Self {
            west_m: low[0] - (WIDTH / scale - x) / 2.0,
            north_m: high[1],
            scale,
            height: (y * scale).max(1.0),
        })
    }

    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [(point[0] - self.west_m) * self.scale, (self.north_m - point[1]) * self.scale]
    }

    /// Path data of rings, thinned to what can be seen.
    fn path(&self, rings: &[Vec<[f64; 2]>]) -> String {
        let mut data = String::new();
        for ring in rings {
            let points = thinned(ring.iter().map(|&p| self.place(p)));
            for (k, [x, y]) in points.iter().enumerate() {
                let _ = write!(data, "{}{x:.2} {y:.2}", if k == 0 { 'M' } else { 'L' });
            }
            if !points.is_empty() {
                data.push('Z');
            }
        }
        data
    }
}

fn thinned(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for point in points.filter(|p| p[0].is_finite() && p[1].is_finite()) {
        let is_far =
            |last: &[f64; 2]| (last[0] - point[0]).abs().max((last[1] - point[1]).abs()) >= TOLERANCE;
        if kept.last().is_none_or(is_far) {
            kept.push(point);
        }
    }
    kept
}

fn image(
    svg: &mut String,
    view: &View,
    raster: Option<&HeightRaster>,
    id: &str,
    attributes: &str,
) -> Result<(), png::EncodingError> {
    let Some(raster) = raster else { return Ok(()) };
    let [west, south, east, north] = raster.rect();
    let ([x0, y0], [x1, y1]) = (view.place([west, north]), view.place([east, south]));
    let _ = writeln!(
        svg,
        "<g id=\"{id}\"{attributes}><rect class=\"nothing\" x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{w:.2}\" height=\"{h:.2}\"/>\
         <image x=\"{x0:.2}\" y=\"{y0:.2}\" width=\"{w:.2}\" height=\"{h:.2}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{data}\"/></g>",
        w = x1 - x0,
        h = y1 - y0,
        data = base64(&raster.to_png()?)
    );
    Ok(())
}

/// One path for all cells of a status: hundreds of thousands of cells stay one element.
fn cells(svg: &mut String, view: &View, drawing: &Drawing) {
    for status in [CellStatus::Untouched, CellStatus::Repaired, CellStatus::Missing, CellStatus::Failed] {
        let mut data = String::new();
        for cell in drawing.cells.iter().filter(|c| c.status == status) {
            let ([x0, y0], [x1, y1]) =
                (view.place([cell.rect[0], cell.rect[3]]), view.place([cell.rect[2], cell.rect[1]]));
            let _ = write!(data, "M{x0:.2} {y0:.2}H{x1:.2}V{y1:.2}H{x0:.2}Z");
            if status == CellStatus::Failed {
                let _ = write!(data, "L{x1:.2} {y1:.2}M{x1:.2} {y0:.2}L{x0:.2} {y1:.2}");
            }
        }
        if !data.is_empty() {
            let _ = writeln!(svg, "<path class=\"cell {}\" d=\"{data}\"/>", status.word());
        }
    }
}

fn draw_hole(svg: &mut String, view: &View, hole: &HoleDrawing, title: &str) {
    let rings: Vec<Vec<[f64; 2]>> =
        hole.rings.iter().map(|ring| thinned(ring.iter().map(|&p| view.place(p)))).collect();
    let Some((low, high)) = extent(&rings) else { return };
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    let class = match hole.class {
        super::HoleClass::Closed => "closed",
        super::HoleClass::Internal => "one",
        super::HoleClass::External => "two",
    };
    let _ = write!(
        svg,
        "<g class=\"hole {class} {}\" data-id=\"{}\"><title>{}</title><path d=\"{}\"/>",
        hole.outcome.word(),
        escaped(&hole.id),
        escaped(title),
        view.path(&hole.rings)
    );
    let [x, y] = widest_place(&rings, low, high);
    if size < SMALLEST {
        let _ = write!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.1}\"/>", SMALLEST / 2.0);
    }
    if hole.outcome == Outcome::Failed {
        let arm = (0.4 * size).clamp(6.0, 20.0);
        let _ = write!(
            svg,
            "<path class=\"cross\" d=\"M{:.2} {:.2}l{d} {d}m0 -{d}l-{d} {d}\"/>",
            x - arm,
            y - arm,
            d = 2.0 * arm
        );
    }
    if size >= LABELLED {
        // The label of a failed hole stands above its cross.
        let y = if hole.outcome == Outcome::Failed { low[1] - 8.0 } else { y };
        let letter = hole.shape.map_or("\u{25cf}", |shape| shape.letter());
        let _ = write!(svg, "<text x=\"{x:.2}\" y=\"{y:.2}\">{letter}{}</text>", hole.layer);
    }
    svg.push_str("</g>\n");
}

fn extent(rings: &[Vec<[f64; 2]>]) -> Option<([f64; 2], [f64; 2])> {
    let mut points = rings.iter().flatten().copied();
    let first = points.next()?;
    let grow = |(low, high): ([f64; 2], [f64; 2]), p: [f64; 2]| {
        ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
    };
    Some(points.fold((first, first), grow))
}

/// The middle of the widest stretch inside the outline on three level lines: a place for the label.
fn widest_place(rings: &[Vec<[f64; 2]>], low: [f64; 2], high: [f64; 2]) -> [f64; 2] {
    let mut best = (0.0, [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0]);
    for share in [0.5, 0.3, 0.7] {
        let y = low[1] + share * (high[1] - low[1]);
        let mut crossings: Vec<f64> = rings.iter().flat_map(|ring| crossings(ring, y)).collect();
        crossings.sort_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            if pair[1] - pair[0] > best.0 {
                best = (pair[1] - pair[0], [(pair[0] + pair[1]) / 2.0, y]);
            }
        }
    }
    best.1
}

/// Where a ring crosses a level line.
fn crossings(ring: &[[f64; 2]], y: f64) -> Vec<f64> {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossing = edges.filter(|(a, b)| (a[1] > y) != (b[1] > y));
    crossing.map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect()
}
