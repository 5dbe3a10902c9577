//! Tables and JSON.

use crate::measure::Figures;
use crate::run::Cost;
use serde::Serialize;
use std::fmt::Write;

/// One program on one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scene's kind.
    pub kind: String,
    /// The scene.
    pub scene: String,
    /// Method of lacuna, or name of another program.
    pub method: String,
    /// What came out, or the sentence why nothing did.
    pub outcome: Result<Outcome, String>,
}

/// Figures and cost of the same run.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// What was measured.
    pub figures: Figures,
    /// Time and memory.
    pub cost: Cost,
}

/// Rows of one kind and method: all seeds.
struct Group<'a> {
    kind: &'a str,
    method: &'a str,
    good: Vec<&'a Outcome>,
    refusal: Option<&'a str>,
}

impl Group<'_> {
    fn mean(&self, value: impl Fn(&Outcome) -> f64) -> f64 {
        self.good.iter().map(|o| value(o)).sum::<f64>() / self.good.len() as f64
    }

    fn most(&self, value: impl Fn(&Outcome) -> f64) -> f64 {
        self.good.iter().map(|o| value(o)).fold(0.0, f64::max)
    }

    /// Mean over the scenes that have the number, with one digit behind the point.
    fn angle(&self, value: impl Fn(&Figures) -> Option<f64>) -> String {
        let known: Vec<f64> = self.good.iter().filter_map(|o| value(&o.figures)).collect();
        if known.is_empty() {
            return "-".to_owned();
        }
        format!("{:.1}", known.iter().sum::<f64>() / known.len() as f64)
    }
}

fn groups(rows: &[Row]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for row in rows {
        let known = groups.iter().position(|g| g.kind == row.kind && g.method == row.method);
        let at = known.unwrap_or_else(|| {
            groups.push(Group { kind: &row.kind, method: &row.method, good: Vec::new(), refusal: None });
            groups.len() - 1
        });
        match &row.outcome {
            Ok(outcome) => groups[at].good.push(outcome),
            Err(why) => groups[at].refusal = Some(why),
        }
    }
    groups
}

/// All tables as Markdown: error, error by depth, shape and cost. Seeds of one kind are one row: means, but the largest
/// of the largest errors and of the peaks.
#[must_use]
pub fn markdown(rows: &[Row]) -> String {
    let groups = groups(rows);
    let mut text = String::new();
    error_table(&groups, &mut text);
    depth_table(&groups, &mut text);
    shape_table(&groups, &mut text);
    let refusals = groups.iter().filter_map(|g| Some((g, g.refusal?)));
    for (group, why) in refusals {
        let _ = writeln!(text, "{}, {}: {why}\n", group.kind, group.method);
    }
    text
}

/// Writing to a text cannot fail, so results of `writeln!` are dropped here.
fn error_table(groups: &[Group<'_>], text: &mut String) {
    text.push_str(
        "| scene | method | scenes | true vertices | mean cm | max cm | sd cm | RMSE cm | bias cm | mean34 cm | missed % |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for group in groups.iter().filter(|g| !g.good.is_empty()) {
        let cm = |value: fn(&Figures) -> f64| 100.0 * group.mean(|o| value(&o.figures));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.0} | {:.2} | {:.1} | {:.2} | {:.2} | {:+.2} | {:.2} | {:.2} |",
            group.kind,
            group.method,
            group.good.len(),
            group.mean(|o| o.figures.error.count as f64),
            cm(|f| f.error.mean_m),
            100.0 * group.most(|o| o.figures.error.max_m),
            cm(|f| f.error.sd_m),
            cm(|f| f.error.rmse_m),
            cm(|f| f.error.bias_m),
            cm(|f| f.error34.mean_m),
            100.0 * group.mean(|o| o.figures.missed),
        );
    }
    text.push('\n');
}

/// Mean absolute error by depth, centimetres, pooled over the scenes of a group.
#[must_use]
pub fn by_depth(outcomes: &[&Outcome]) -> Vec<(f64, f64)> {
    let bins = outcomes.first().map_or(0, |o| o.figures.depths.len());
    (0..bins)
        .map(|k| {
            let bins = || outcomes.iter().map(|o| &o.figures.depths[k]);
            let count: usize = bins().map(|b| b.count).sum();
            let sum_m: f64 = bins().map(|b| b.sum_m).sum();
            (outcomes[0].figures.depths[k].depth, 100.0 * sum_m / f64::max(count as f64, 1.0))
        })
        .collect()
}

fn depth_table(groups: &[Group<'_>], text: &mut String) {
    let Some(first) = groups.iter().find(|g| !g.good.is_empty()) else { return };
    text.push_str("| scene | method |");
    for (depth, _) in by_depth(&first.good) {
        let _ = write!(text, " to {depth:.3} |");
    }
    text.push_str("\n| --- | --- |");
    text.push_str(&" --- |".repeat(first.good[0].figures.depths.len()));
    text.push('\n');
    for group in groups.iter().filter(|g| !g.good.is_empty()) {
        let _ = write!(text, "| {} | {} |", group.kind, group.method);
        for (_, mean_cm) in by_depth(&group.good) {
            let _ = write!(text, " {mean_cm:.2} |");
        }
        text.push('\n');
    }
    text.push('\n');
}

fn shape_table(groups: &[Group<'_>], text: &mut String) {
    text.push_str(
        "| scene | method | rim deg (p95) | around deg (p95) | seam deg (p95) | inside deg (p95) | 2r/R | above 0.5 % | \
         new triangles | seconds | peak MiB |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for group in groups.iter().filter(|g| !g.good.is_empty()) {
        let pair = |angles: fn(&Figures) -> &crate::slope::Angles| {
            let median = group.angle(|f| angles(f).median_deg);
            format!("{median} ({})", group.angle(|f| angles(f).p95_deg))
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {:.3} | {:.1} | {:.0} | {:.2} | {:.0} |",
            group.kind,
            group.method,
            pair(|f| &f.slopes.rim),
            pair(|f| &f.slopes.around),
            pair(|f| &f.slopes.seam),
            pair(|f| &f.slopes.inside),
            group.mean(|o| o.figures.quality_mean),
            100.0 * group.mean(|o| o.figures.quality_share),
            group.mean(|o| o.figures.new_triangles as f64),
            group.mean(|o| o.cost.seconds),
            group.most(|o| o.cost.peak_mib),
        );
    }
    text.push('\n');
}
