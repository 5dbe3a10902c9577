//! A line chart as SVG: linear or logarithmic axes, ticks at round numbers, level lines for limits.

use std::fmt::Write;

/// Size of the picture, and the room round the axes: left, right, top, bottom.
const SIZE: [f64; 2] = [680.0, 360.0];
const ROOM: [f64; 4] = [64.0, 24.0, 48.0, 52.0];

/// A limit that is higher than so many times the highest point would press the curves flat.
const FARTHEST_LIMIT: f64 = 4.0;

/// How an axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// From 0 on.
    Linear,
    /// By factors; only values above 0 are drawn.
    Logarithmic,
}

/// A named line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// What the legend calls it.
    pub(super) name: String,
    /// From left to right.
    pub(super) points: Vec<[f64; 2]>,
    /// Whether the points are marked: measured ones are, sampled ones are too many.
    pub(super) has_marks: bool,
}

/// What to draw.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chart<'a> {
    /// Above the picture.
    pub(super) title: &'a str,
    /// What x and y are, with units.
    pub(super) axes: [&'a str; 2],
    /// How x and y count.
    pub(super) scales: [Scale; 2],
    /// In the order of the legend.
    pub(super) curves: Vec<Curve>,
    /// A level with its name: a dashed line, if it is not far above all points.
    pub(super) limit: Option<(&'a str, f64)>,
}

/// Colours of names, the same in every picture; others take those of [`OTHERS`] in the order of the legend.
const NAMED: [(&str, &str); 5] = [
    ("field", "#1f6feb"),
    ("layered", "#d29922"),
    ("aggregate", "#cf222e"),
    ("copy", "#57606a"),
    ("read", "#8c959f"),
];
/// Dashes of the first, second ... curve of one colour: a method with several numbers of threads.
const DASHES: [&str; 4] = ["none", "7 3", "3 3", "1 3"];
const OTHERS: [&str; 3] = ["#1a7f37", "#8250df", "#bf3989"];

impl Chart<'_> {
    /// The picture; `None` if there is nothing to draw.
    pub(super) fn to_svg(&self) -> Option<String> {
        let frame = Frame::of(self)?;
        let mut svg = String::new();
        let [w, h] = SIZE;
        let _ = writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n\
             <text x=\"{}\" y=\"18\" text-anchor=\"middle\" font-size=\"13\">{}</text>",
            w / 2.0,
            escaped(self.title)
        );
        self.draw_axes(&frame, &mut svg);
        if let Some((name, level)) = self.limit {
            draw_limit(&frame, name, level, &mut svg);
        }
        for (k, curve) in self.curves.iter().enumerate() {
            let colour = colour(curve, k);
            let same =
                self.curves[..k].iter().enumerate().filter(|(i, c)| self::colour(c, *i) == colour).count();
            let pen = Pen { colour, dashes: DASHES[same.min(DASHES.len() - 1)] };
            draw_curve(&frame, curve, k, &pen, &mut svg);
        }
        svg.push_str("</svg>\n");
        Some(svg)
    }

    fn draw_axes(&self, frame: &Frame, svg: &mut String) {
        let [left, right, top, bottom] = [ROOM[0], SIZE[0] - ROOM[1], ROOM[2], SIZE[1] - ROOM[3]];
        for tick in frame.ticks(0) {
            let (x, text) = (frame.place(0, tick), number(tick));
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#eaeef2\"/>\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
                bottom + 15.0
            );
        }
        for tick in frame.ticks(1) {
            let (y, text) = (frame.place(1, tick), number(tick));
            let _ = writeln!(
                svg,
                "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#eaeef2\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
                left - 6.0,
                y + 4.0
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {top}V{bottom}H{right}\" fill=\"none\" stroke=\"#57606a\"/>\n\
             <text x=\"{right}\" y=\"{}\" text-anchor=\"end\">{}</text>\n<text x=\"{left}\" y=\"{}\">{}</text>",
            bottom + 30.0,
            escaped(self.axes[0]),
            top - 8.0,
            escaped(self.axes[1])
        );
    }
}

/// A dashed line, or a note above the picture where the limit is far beyond what is drawn.
fn draw_limit(frame: &Frame, name: &str, level: f64, svg: &mut String) {
    let (x0, x1) = (ROOM[0], SIZE[0] - ROOM[1]);
    let is_inside = frame.count(1, level) <= frame.high[1];
    let (y, text) = if is_inside {
        let y = frame.place(1, level);
        let _ = writeln!(
            svg,
            "<path d=\"M{x0} {y:.1}H{x1}\" class=\"limit\" stroke=\"#24292f\" stroke-dasharray=\"5 4\"/>"
        );
        (y - 4.0, escaped(name))
    } else {
        (ROOM[2] - 8.0, format!("{}: {}, beyond this picture", escaped(name), number(level)))
    };
    let _ = writeln!(svg, "<text x=\"{x1}\" y=\"{y:.1}\" text-anchor=\"end\">{text}</text>");
}

/// The colour of the curve at place `k` of the legend.
fn colour(curve: &Curve, k: usize) -> &'static str {
    let named = NAMED.iter().find(|n| curve.name.starts_with(n.0)).map(|n| n.1);
    named.unwrap_or(OTHERS[k % OTHERS.len()])
}

/// How a curve is drawn.
struct Pen {
    colour: &'static str,
    dashes: &'static str,
}

fn draw_curve(frame: &Frame, curve: &Curve, k: usize, pen: &Pen, svg: &mut String) {
    let Pen { colour, dashes } = pen;
    let places: Vec<[f64; 2]> = curve
        .points
        .iter()
        .filter(|p| frame.shows(**p))
        .map(|p| [frame.place(0, p[0]), frame.place(1, p[1])])
        .collect();
    let corners: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
    if !corners.is_empty() {
        let _ = writeln!(
            svg,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" stroke-dasharray=\"{dashes}\"/>",
            corners.join("L")
        );
    }
    if curve.has_marks {
        for [x, y] in &places {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\" fill=\"{colour}\"/>");
        }
    }
    let (x, y) = (ROOM[0] + 100.0 * k as f64, SIZE[1] - 8.0);
    let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\" fill=\"{colour}\">{}</text>", escaped(&curve.name));
}

/// What the axes span, in their own counting.
struct Frame {
    scales: [Scale; 2],
    low: [f64; 2],
    high: [f64; 2],
}

impl Frame {
    fn of(chart: &Chart<'_>) -> Option<Self> {
        let mut frame = Self { scales: chart.scales, low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        let points: Vec<[f64; 2]> =
            chart.curves.iter().flat_map(|c| c.points.iter().copied()).filter(|p| frame.shows(*p)).collect();
        let most = points.iter().map(|p| p[1]).fold(0.0, f64::max);
        let level = chart.limit.map(|(_, y)| y).filter(|y| *y <= FARTHEST_LIMIT * most);
        for axis in 0..2 {
            let values = points.iter().map(|p| p[axis]).chain(level.filter(|_| axis == 1));
            for value in values {
                let value = frame.count(axis, value);
                frame.low[axis] = frame.low[axis].min(value);
                frame.high[axis] = frame.high[axis].max(value);
            }
            if frame.scales[axis] == Scale::Linear {
                frame.low[axis] = 0.0;
            }
            let span = (frame.high[axis] - frame.low[axis]).max(1e-9);
            frame.high[axis] += 0.05 * span;
            if frame.scales[axis] == Scale::Logarithmic {
                frame.low[axis] -= 0.05 * span;
            }
        }
        (!points.is_empty()).then_some(frame)
    }

    fn shows(&self, point: [f64; 2]) -> bool {
        (0..2).all(|k| point[k].is_finite() && (self.scales[k] == Scale::Linear || point[k] > 0.0))
    }

    fn count(&self, axis: usize, value: f64) -> f64 {
        match self.scales[axis] {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        }
    }

    fn place(&self, axis: usize, value: f64) -> f64 {
        let share = (self.count(axis, value) - self.low[axis]) / (self.high[axis] - self.low[axis]);
        if axis == 0 {
            ROOM[0] + share * (SIZE[0] - ROOM[0] - ROOM[1])
        } else {
            SIZE[1] - ROOM[3] - share * (SIZE[1] - ROOM[2] - ROOM[3])
        }
    }

    /// Round numbers on an axis: 1, 2 and 5 times powers of ten (over more than three decades only the powers).
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let (low, high) = (self.low[axis], self.high[axis]);
        if self.scales[axis] == Scale::Linear {
            let step = round_step((high - low) / 6.0);
            return (0..=100).map(|k| f64::from(k) * step).take_while(|v| *v <= high).collect();
        }
        let factors: &[f64] = if high - low > 3.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let powers = (low.floor() as i32)..=(high.ceil() as i32);
        let all = powers.flat_map(|p| factors.iter().map(move |f| f * 10.0_f64.powi(p)));
        all.filter(|v| (low..=high).contains(&v.log10())).collect()
    }
}

/// The least of 1, 2, 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    let power = 10.0_f64.powi(least.log10().floor() as i32);
    [1.0, 2.0, 5.0].into_iter().map(|f| f * power).find(|s| *s >= least).unwrap_or(10.0 * power)
}

fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::{Chart, Curve, Frame, Scale};

    fn chart(scale: Scale, points: &[[f64; 2]]) -> Chart<'static> {
        let curves = vec![Curve { name: "field".to_owned(), points: points.to_vec(), has_marks: true }];
        Chart { title: "a < b", axes: ["x", "y"], scales: [scale; 2], curves, limit: None }
    }

    #[test]
    fn ticks_are_round_and_inside() {
        for (scale, high, expected) in [
            (Scale::Linear, 10.0, vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]),
            (Scale::Linear, 7.0, vec![0.0, 2.0, 4.0, 6.0]),
            (Scale::Logarithmic, 30.0, vec![1.0, 2.0, 5.0, 10.0, 20.0]),
        ] {
            let frame = Frame::of(&chart(scale, &[[1.0, 1.0], [high, high]])).expect("points");
            let ticks = frame.ticks(0);
            let is_near = ticks.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(ticks.len() == expected.len() && is_near, "{ticks:?}");
        }
    }

    #[test]
    fn a_limit_is_a_line_where_it_is_near_and_a_note_where_it_is_far() {
        for (level, is_line) in [(5.0, true), (40.0, true), (41.0, false)] {
            let limited =
                Chart { limit: Some(("limit", level)), ..chart(Scale::Linear, &[[0.0, 1.0], [1.0, 10.0]]) };
            let svg = limited.to_svg().expect("a picture");
            assert_eq!(svg.contains("class=\"limit\""), is_line, "{level}");
            assert_eq!(svg.contains("limit: 41, beyond"), !is_line, "{level}");
        }
    }

    #[test]
    fn every_point_lies_in_the_picture_and_nothing_draws_nothing() {
        let points = [[0.5, 3.0], [28.0, 4000.0], [0.0, -1.0], [f64::NAN, 2.0]];
        let svg = chart(Scale::Logarithmic, &points).to_svg().expect("a picture");
        assert_eq!(svg.matches("<circle").count(), 2, "what a logarithm does not have is left out");
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert!(chart(Scale::Logarithmic, &[[0.0, 0.0]]).to_svg().is_none());
        let single = chart(Scale::Linear, &[[2.0, 0.0]]).to_svg().expect("one point");
        assert!(!single.contains("NaN") && !single.contains("inf"), "{single}");
    }
}
