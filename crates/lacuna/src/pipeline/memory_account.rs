//! What the scan may hold: the tile in work beside the surveys that stay, and the limit to ask for if that is too much.

use super::context::{BASE_BYTES, Context, limit_for};
use super::error::{RunError, Shortage};
use super::scan::tile_bytes;
use lacuna_schedule::Job;
use lacuna_tile::{Scene, TileGroup};
use std::sync::atomic::{AtomicU64, Ordering};

/// Memory of a fill, bytes an unknown; a hole has 1.2 unknowns for every vertex that is missing.
const FILL_BYTES_A_VERTEX: f64 = 1.2 * 2400.0;

/// Bytes that are scanned and what they left in memory.
pub(crate) struct MemoryAccount<'a> {
    scene: &'a Scene,
    context: &'a Context<'a>,
    scanned_bytes: AtomicU64,
}

impl<'a> MemoryAccount<'a> {
    pub(crate) fn new(scene: &'a Scene, context: &'a Context<'a>) -> Self {
        Self { scene, context, scanned_bytes: AtomicU64::new(0) }
    }

    /// An error if the limit does not hold the tile that needs most, in the scan (`jobs`, one a tile) or when it is
    /// written: before anything is read.
    pub(crate) fn check_largest(&self, jobs: &[Job]) -> Result<(), RunError> {
        let writes = self.context.writes_tiles();
        let need = |k: usize| {
            let write = if writes { 2 * self.group_bytes(k) + (1 << 20) } else { 0 };
            jobs[k].bytes.max(write)
        };
        let Some(largest) = (0..jobs.len()).max_by_key(|&k| (need(k), std::cmp::Reverse(k))) else {
            return Ok(());
        };
        self.context.expect_tile(need(largest));
        if need(largest) <= self.context.budget.total_bytes() {
            return Ok(());
        }
        Err(self.too_small(largest, need(largest)))
    }

    /// Takes what a scanned tile leaves in memory out of the budget.
    pub(crate) fn keep(&self, group: usize, kept_bytes: u64) {
        self.scanned_bytes.fetch_add(self.group_bytes(group), Ordering::Relaxed);
        self.context.budget.keep(kept_bytes);
    }

    /// An error if what all tiles leave in memory is more than the limit.
    pub(crate) fn check_kept(&self) -> Result<(), RunError> {
        let kept = self.context.budget.kept_bytes();
        let limit_bytes = self.context.settings.run.memory_limit_bytes;
        if BASE_BYTES.saturating_add(kept) <= limit_bytes.max(BASE_BYTES) {
            return Ok(());
        }
        Err(RunError::memory_too_small(
            "what the scan keeps of all tiles",
            &Shortage {
                needed_bytes: kept,
                held_bytes: BASE_BYTES,
                limit_bytes,
                least_bytes: self.least_bytes(0),
            },
        ))
    }

    /// The error for a tile that does not fit beside what is kept.
    pub(crate) fn too_small(&self, group: usize, needed_bytes: u64) -> RunError {
        RunError::memory_too_small(
            &format!("tile {}", self.scene.groups[group].name),
            &Shortage {
                needed_bytes,
                held_bytes: BASE_BYTES.saturating_add(self.context.budget.kept_bytes()),
                limit_bytes: self.context.settings.run.memory_limit_bytes,
                least_bytes: self.least_bytes(needed_bytes),
            },
        )
    }

    /// A limit for the whole run: for what is kept of all tiles, if they are like those that are scanned, beside the
    /// tile in work or, if holes are filled, a hole as large as the largest tile.
    fn least_bytes(&self, needed_bytes: u64) -> u64 {
        let groups = 0..self.scene.groups.len();
        let all: u64 = groups.clone().map(|k| self.group_bytes(k)).sum();
        let scanned = self.scanned_bytes.load(Ordering::Relaxed);
        let kept = u128::from(self.context.budget.kept_bytes()) * u128::from(all);
        let kept = u64::try_from(kept / u128::from(scanned.max(1))).unwrap_or(u64::MAX);
        let vertices = groups.map(|k| self.vertices(&self.scene.groups[k])).max().unwrap_or(0);
        let fill = if self.context.writes_tiles() { fill_bytes(vertices as f64) } else { 0 };
        limit_for(BASE_BYTES.saturating_add(kept), needed_bytes.max(fill))
    }

    fn group_bytes(&self, group: usize) -> u64 {
        self.scene.groups[group].parts.iter().map(|&p| tile_bytes(self.scene, p)).sum()
    }

    fn vertices(&self, group: &TileGroup) -> u64 {
        let of = |p: &usize| self.scene.tiles[*p].header.as_ref().map_or(0, |h| h.vertices);
        group.parts.iter().map(of).fold(0, u64::saturating_add)
    }
}

/// Memory for filling a square hole in the place of so many vertices; its rim counts four times, and is met twice (as
/// rim and as closing line).
fn fill_bytes(vertices: f64) -> u64 {
    let rim = 4.0 * vertices.sqrt();
    (FILL_BYTES_A_VERTEX * vertices + 2400.0 * 4.0 * 2.0 * rim) as u64 + (1 << 20)
}
