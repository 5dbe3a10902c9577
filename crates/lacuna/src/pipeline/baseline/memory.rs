//! What the baseline needs in memory: known from headers and plan, before a tile is read.

use super::AggregateInput;
use super::fill::LARGEST_RING;
use crate::pipeline::RunError;
use crate::pipeline::context::Context;
use crate::pipeline::scan::{Part, tile_bytes};
use std::collections::BTreeMap;

/// What a shortage names.
const WHOLE_SCENE: &str = "the merged mesh of all tiles (aggregate)";
pub(super) const LARGEST_HOLE: &str = "the largest hole of the merged mesh (aggregate)";

/// Bytes a vertex and a triangle of the merged mesh: columns, edge balance, and slack of the allocator.
const BYTES_A_VERTEX: u64 = 56;
const BYTES_A_TRIANGLE: u64 = 24;
/// Bytes a pair of rim vertices in the table of the minimum-area triangulation.
const BYTES_A_PAIR: f64 = 20.0;
/// Bytes an unknown place of the fairing.
const BYTES_AN_UNKNOWN: f64 = 2400.0;

/// An error if the limit does not hold the merged mesh, or the largest hole after it.
///
/// # Errors
/// Exit 5, with a limit that is enough.
pub(super) fn check(input: &AggregateInput<'_>, context: &Context<'_>) -> Result<(), RunError> {
    let left_bytes = context.budget_beside(0).total_bytes();
    let mut clusters: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &h in input.todo {
        clusters.entry(input.plan.holes[h as usize].cluster).or_default().push(h);
    }
    let largest = clusters.values().map(|holes| fill_bytes(input, holes)).max().unwrap_or(0);
    context.expect_tile(largest);
    let merged = merge_bytes(input);
    context.expect_tile(merged);
    for (what, needed) in [(WHOLE_SCENE, merged), (LARGEST_HOLE, largest)] {
        if needed > left_bytes {
            return Err(context.memory_too_small(what, needed, left_bytes));
        }
    }
    Ok(())
}

/// Memory of the merged mesh, beside the file that is read into it.
pub(super) fn merge_bytes(input: &AggregateInput<'_>) -> u64 {
    let (mut merged, mut largest) = (1u64 << 20, 0);
    for part in parts(input) {
        let (vertices, triangles) = counts(input, part);
        let mesh = |a_vertex: u64, a_triangle: u64| {
            vertices.saturating_mul(a_vertex).saturating_add(triangles.saturating_mul(a_triangle))
        };
        merged = merged.saturating_add(mesh(BYTES_A_VERTEX, BYTES_A_TRIANGLE));
        largest = largest.max(mesh(24, 12).saturating_add(tile_bytes(input.scene, part.tile)));
    }
    merged.saturating_add(largest)
}

/// Vertices and triangles that a file's header names.
pub(super) fn counts(input: &AggregateInput<'_>, part: &Part) -> (u64, u64) {
    let header = input.scene.tiles[part.tile].header.as_ref();
    header.map_or((u64::from(part.vertices), 0), |h| (h.vertices, h.triangles))
}

/// The files of all tiles, in the order in which they are merged.
pub(super) fn parts<'a>(input: &'a AggregateInput<'_>) -> impl Iterator<Item = &'a Part> {
    input.scanned.tiles.values().flat_map(|t| &t.parts)
}

/// Memory of one merged hole: the table of its triangulation, and the fairing of as many places as its area takes at
/// the rim's density.
pub(super) fn fill_bytes(input: &AggregateInput<'_>, holes: &[u32]) -> u64 {
    let records = || holes.iter().map(|&h| &input.plan.holes[h as usize]);
    let spacing = holes.first().and_then(|&h| (input.settings_of)(h).spacing_m);
    let edge_m = spacing.unwrap_or_else(|| input.plan.fit.edge_m.max(1e-3));
    let rim: f64 = records().map(|h| f64::from(h.rim_vertices)).sum();
    let area_m2: f64 = records().map(|h| h.area_m2.max(0.0)).sum();
    let table = if rim <= LARGEST_RING as f64 { BYTES_A_PAIR * rim * rim } else { 0.0 };
    let unknowns = 1.2 * area_m2 / (edge_m * edge_m) + 4.0 * rim;
    ((table + BYTES_AN_UNKNOWN * unknowns) as u64).saturating_add(1 << 20)
}
