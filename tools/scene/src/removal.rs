//! Which triangles of a cell are left out, and the clean-up of the rims.
//!
//! The clean-up looks at what lies within one node of a triangle, in a fixed number of rounds. With a halo of
//! [`HALO`] quads a cell's result is that of the whole scene, so any cell can be made alone.

use crate::area::{Area, Cell};
use crate::hole::Hole;
use crate::lattice::{Lattice, UNITS_PER_M};

/// Rounds of the clean-up.
const ROUNDS: usize = 5;
/// Quads round a cell that its clean-up may depend on: each round looks two quads far, the final check one.
pub const HALO: i64 = 2 * ROUNDS as i64 + 2;

/// A hole with its index in the plan.
pub type Numbered<'a> = (u32, &'a Hole);

/// What became of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// In the scene.
    Kept,
    /// Left out for this hole (index into the plan's holes).
    Removed(u32),
    /// Outside the area: there never was a triangle.
    Absent,
}

impl State {
    /// The hole, if left out for one.
    #[must_use]
    pub fn hole(self) -> Option<u32> {
        match self {
            Self::Removed(hole) => Some(hole),
            _ => None,
        }
    }
}

/// States of all triangles of a lattice after the clean-up; `None` if a rim of the cell is still pinched or has
/// hanging triangles after [`ROUNDS`] rounds.
///
/// `holes` are those that may reach the lattice.
///
/// 1. Triangles whose centroid a hole takes are left out.
/// 2. Round a vertex (in the whole scene, and in each cell alone) the kept triangles must be one run: all but the
///    largest run go. In a cell, a run at a border vertex must also reach the border.
/// 3. Triangles that hang by one edge or none go.
#[must_use]
pub fn remove(lattice: &Lattice, area: &Area, holes: &[Numbered]) -> Option<Vec<State>> {
    let mut states = first_states(lattice, area, holes);
    if states.iter().any(|s| s.hole().is_some()) {
        for _ in 0..ROUNDS {
            let doomed = pinching(lattice, &states, false);
            let hanging = apply(&mut states, doomed) | {
                let doomed = hanging(lattice, &states, false);
                apply(&mut states, doomed)
            };
            if !hanging {
                break;
            }
        }
        if !pinching(lattice, &states, true).is_empty() || !hanging(lattice, &states, true).is_empty() {
            return None;
        }
    }
    Some(states)
}

/// Triangles to leave out, with the hole they join.
type Doomed = Vec<(usize, u32)>;

fn apply(states: &mut [State], doomed: Doomed) -> bool {
    let any = !doomed.is_empty();
    for (triangle, hole) in doomed {
        states[triangle] = State::Removed(hole);
    }
    any
}

fn first_states(lattice: &Lattice, area: &Area, holes: &[Numbered]) -> Vec<State> {
    (0..lattice.triangle_count())
        .map(|t| {
            let cell = lattice.cell_of(t / 2);
            if area.contains(cell) { state_in_plan(lattice, cell, t, holes) } else { State::Absent }
        })
        .collect()
}

fn state_in_plan(lattice: &Lattice, cell: Cell, triangle: usize, holes: &[Numbered]) -> State {
    let corners = lattice.corners(triangle).map(|v| lattice.nodes[v]);
    let centroid = [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<i64>() as f64 / (3.0 * UNITS_PER_M));
    let hole = holes.iter().find(|(_, h)| h.takes(cell, centroid));
    hole.map_or(State::Kept, |(number, _)| State::Removed(*number))
}

/// Kept triangles in the smaller runs round a vertex. With `inner`, only nodes of the cell in the middle are looked at.
fn pinching(lattice: &Lattice, states: &[State], inner: bool) -> Doomed {
    let halo = lattice.halo();
    let range = if inner || halo == 0 { halo..=halo + lattice.quads() } else { 1..=lattice.across() - 1 };
    let mut doomed = Doomed::new();
    for b in range.clone() {
        for a in range.clone() {
            pinching_at(lattice, states, a, b, &mut doomed);
        }
    }
    doomed
}

fn pinching_at(lattice: &Lattice, states: &[State], a: usize, b: usize, doomed: &mut Doomed) {
    let fan = lattice.fan(a, b);
    let Some(hole) = fan.iter().flatten().flatten().find_map(|&t| states[t].hole()) else { return };
    let kept = |t: &Option<usize>| t.is_some_and(|t| states[t] == State::Kept);
    let all: Vec<Option<usize>> = [0, 1, 2, 3].into_iter().flat_map(|k| triangles_or_gap(&fan[k])).collect();
    let runs = cyclic_runs(&all.iter().map(kept).collect::<Vec<_>>());
    doom_smaller(&all, &runs, hole, doomed);
    for group in cell_sectors(lattice, a, b) {
        let sector: Vec<Option<usize>> = group.iter().flat_map(|&k| triangles_or_gap(&fan[k])).collect();
        if !sector.iter().flatten().any(|&t| states[t].hole().is_some()) {
            continue;
        }
        let mut runs = linear_runs(&sector.iter().map(kept).collect::<Vec<_>>());
        for run in runs.extract_if(.., |r| r[0] > 0 && r[0] + r[1] < sector.len()) {
            doomed.extend(triangles_of(&sector, run).map(|t| (t, hole)));
        }
        doom_smaller(&sector, &runs, hole, doomed);
    }
}

/// A quadrant's triangles; one gap if it has none.
fn triangles_or_gap(quadrant: &[Option<usize>; 2]) -> impl Iterator<Item = Option<usize>> {
    let [first, second] = *quadrant;
    std::iter::once(first).chain(second.map(Some))
}

/// The quadrants of each cell that meets in a border node, counter-clockwise; none at an inner node.
fn cell_sectors(lattice: &Lattice, a: usize, b: usize) -> &'static [&'static [usize]] {
    match (lattice.is_cell_line(a), lattice.is_cell_line(b)) {
        (false, false) => &[],
        (true, false) => &[&[3, 0], &[1, 2]],
        (false, true) => &[&[0, 1], &[2, 3]],
        (true, true) => &[&[0], &[1], &[2], &[3]],
    }
}

/// Start and length of the runs of `true`.
fn linear_runs(kept: &[bool]) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (k, _) in kept.iter().enumerate().filter(|(_, kept)| **kept) {
        match runs.last_mut() {
            Some(run) if run[0] + run[1] == k => run[1] += 1,
            _ => runs.push([k, 1]),
        }
    }
    runs
}

/// The same where the last follows on the first: a run over the end starts near it.
fn cyclic_runs(kept: &[bool]) -> Vec<[usize; 2]> {
    let mut runs = linear_runs(kept);
    let wraps = runs.len() > 1 && runs[0][0] == 0 && runs.last().is_some_and(|r| r[0] + r[1] == kept.len());
    if wraps {
        let first = runs.remove(0);
        if let Some(last) = runs.last_mut() {
            last[1] += first[1];
        }
    }
    runs
}

fn triangles_of(ring: &[Option<usize>], run: [usize; 2]) -> impl Iterator<Item = usize> {
    (run[0]..run[0] + run[1]).filter_map(|k| ring[k % ring.len()])
}

/// Dooms all runs but the longest (the first of equals).
fn doom_smaller(ring: &[Option<usize>], runs: &[[usize; 2]], hole: u32, doomed: &mut Doomed) {
    let longest = runs.iter().map(|r| r[1]).max().unwrap_or(0);
    let Some(keep) = runs.iter().position(|r| r[1] == longest) else { return };
    for run in runs.iter().enumerate().filter(|(k, _)| *k != keep).map(|(_, run)| *run) {
        doomed.extend(triangles_of(ring, run).map(|t| (t, hole)));
    }
}

/// Kept triangles with a removed neighbour in their own cell that have a second one, or no kept one in their cell.
///
/// The corner triangle of a cell between two hollow ones stays: in its own tile nothing is missing.
fn hanging(lattice: &Lattice, states: &[State], inner: bool) -> Doomed {
    let candidates = (0..states.len()).filter(|t| states[*t] == State::Kept);
    candidates
        .filter(|t| !inner || lattice.is_inner(t / 2))
        .filter_map(|t| hangs_in(lattice, states, t).map(|hole| (t, hole)))
        .collect()
}

/// The hole into which a kept triangle hangs, if it does.
fn hangs_in(lattice: &Lattice, states: &[State], triangle: usize) -> Option<u32> {
    let neighbours = lattice.neighbours(triangle);
    let removed = neighbours.iter().flatten().filter_map(|&t| states[t].hole());
    let hole = removed.clone().min()?;
    let own = lattice.cell_of(triangle / 2);
    let at_home = || neighbours.iter().flatten().filter(|&&t| lattice.cell_of(t / 2) == own);
    let held = at_home().any(|&t| states[t] == State::Kept);
    let bitten = at_home().any(|&t| states[t].hole().is_some());
    (bitten && (removed.count() >= 2 || !held)).then_some(hole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_a_ring_join_over_its_end() {
        let cases: [(&[bool], &[[usize; 2]]); 4] = [
            (&[true, false, true, true], &[[2, 3]]),
            (&[false, true, false, true], &[[1, 1], [3, 1]]),
            (&[true, true], &[[0, 2]]),
            (&[false, false], &[]),
        ];
        for (ring, runs) in cases {
            assert_eq!(cyclic_runs(ring), runs);
        }
    }
}
