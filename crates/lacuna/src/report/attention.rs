//! What a reader of the report should look at first.

use super::kind::HoleClass;
use super::model::{ClusterRecord, HoleRecord, Outcome, Report};
use super::numbers;

/// Most failures that are named one by one.
const MAX_FAILURES: usize = 5;

/// Share of good triangles below which a patch is worth a look.
const LOW_QUALITY: f64 = 0.9;

/// One thing to look at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attention {
    /// `failed`, `tile`, `seam`, `largest`, `quality`, `islands`, `edge`.
    pub topic: &'static str,
    /// A sentence; names in it are as the input has them, to be escaped by whoever shows it.
    pub text: String,
    /// The cluster or hole it is about.
    pub id: Option<String>,
}

/// What to look at first: failures, bad tiles, seams that do not meet, the largest lakes, the worst patches, islands that
/// keep an open rim, and what was left at the edge of the area. Ties go by the report's order.
#[must_use]
pub fn attention(report: &Report) -> Vec<Attention> {
    let mut list = failures(report);
    list.extend(bad_tiles(report));
    list.extend(open_seams(report));
    list.extend(largest(report));
    list.extend(lowest_quality(report));
    list.extend(passed_under(report));
    list.extend(left_at_the_edge(report));
    list
}

fn failures(report: &Report) -> Vec<Attention> {
    let failed: Vec<&ClusterRecord> =
        report.clusters.iter().filter(|c| c.outcome == Outcome::Failed).collect();
    let mut list: Vec<Attention> = failed.iter().take(MAX_FAILURES).map(|c| failure(c)).collect();
    if failed.len() > MAX_FAILURES {
        let more = (failed.len() - MAX_FAILURES) as u64;
        let text =
            format!("{} more failed; the report names them", numbers::count(more, "cluster", "clusters"));
        list.push(Attention { topic: "failed", text, id: None });
    }
    list
}

fn failure(cluster: &ClusterRecord) -> Attention {
    let tiles = match cluster.tiles.as_slice() {
        [] => "no tile".to_owned(),
        [only] => only.clone(),
        [first, rest @ ..] => format!("{first} and {} more", rest.len()),
    };
    let reason = cluster.reason.as_deref().unwrap_or("no cause given");
    let text = format!("{tiles} at {}: {reason}", place(cluster));
    Attention { topic: "failed", text, id: Some(cluster.id.clone()) }
}

/// Where a cluster lies, to the decimetre: as `--at` takes it.
pub(crate) fn place(cluster: &ClusterRecord) -> String {
    format!("{:.1},{:.1}", cluster.x, cluster.y)
}

fn bad_tiles(report: &Report) -> Option<Attention> {
    let bad: Vec<_> = report.defects.iter().filter(|d| d.unusable).collect();
    let first = bad.first()?;
    let more = match bad.len() - 1 {
        0 => String::new(),
        n => format!(" ({n} more tiles could not be used)"),
    };
    Some(Attention { topic: "tile", text: format!("{}: {}{more}", first.tile, first.what), id: None })
}

fn open_seams(report: &Report) -> Option<Attention> {
    let seams = &report.seams;
    if seams.differing_vertices == 0 && seams.max_gap_m <= 0.001 {
        return None;
    }
    let text = format!(
        "{} on repaired borders have no partner; the widest gap is {:.4} m",
        numbers::count(seams.differing_vertices, "vertex", "vertices"),
        seams.max_gap_m
    );
    Some(Attention { topic: "seam", text, id: None })
}

fn largest(report: &Report) -> Option<Attention> {
    let filled = report.clusters.iter().filter(|c| c.outcome == Outcome::Filled);
    // `max_by` takes the last of equals; reversed, that is the first.
    let cluster = filled.rev().max_by(|a, b| a.area_m2.total_cmp(&b.area_m2))?;
    let tiles = numbers::count(cluster.tiles.len() as u64, "tile", "tiles");
    let text = format!("{} m2 over {tiles}, filled, at {}", numbers::area(cluster.area_m2), place(cluster));
    Some(Attention { topic: "largest", text, id: Some(cluster.id.clone()) })
}

fn lowest_quality(report: &Report) -> Option<Attention> {
    let judged = report.holes.iter().filter_map(|h| Some((h, h.quality_share_good?)));
    let (hole, share) =
        judged.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share < LOW_QUALITY)?;
    let text = format!("{:.0} % of the patch's triangles are well shaped", share * 100.0);
    Some(Attention { topic: "quality", text, id: Some(hole.id.clone()) })
}

fn passed_under(report: &Report) -> Option<Attention> {
    let holes: Vec<&HoleRecord> = report.holes.iter().filter(|h| h.islands_passed_under > 0).collect();
    let first = holes.first()?;
    let islands = numbers::count(holes.iter().map(|h| h.islands_passed_under).sum(), "island", "islands");
    let holes = numbers::count(holes.len() as u64, "hole", "holes");
    let text = format!("{islands} over the water of {holes}: the water passes beneath");
    Some(Attention { topic: "islands", text, id: Some(first.id.clone()) })
}

fn left_at_the_edge(report: &Report) -> Option<Attention> {
    let is_left = |h: &&HoleRecord| h.class == HoleClass::External && h.outcome == Outcome::Skipped;
    let left: Vec<&HoleRecord> = report.holes.iter().filter(is_left).collect();
    if left.is_empty() {
        return None;
    }
    let area_m2: f64 = left.iter().map(|h| h.area_m2).sum();
    let holes = numbers::count(left.len() as u64, "hole", "holes");
    let text = format!("{holes} at the edge of the area, {} m2, left open", numbers::area(area_m2));
    Some(Attention { topic: "edge", text, id: None })
}
