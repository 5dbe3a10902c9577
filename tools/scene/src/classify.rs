//! The classes a cell shows, from its triangles alone (Wang et al. 2021, sec. 3.1).
//!
//! Works on sets of triangles, not on rims: a hole is an edge-connected set of left-out triangles of the cell. Its
//! openings are its edges on the cell's perimeter; the stretches of perimeter between them belong to one piece of
//! surface each.

use crate::area::{Area, SIDES, Side, beyond};
use crate::class::{Class, Form};
use crate::lattice::Lattice;
use crate::removal::State;

/// One hole of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Index into the plan's holes.
    pub hole: u32,
    /// Its class here.
    pub class: Class,
    /// Left-out triangles.
    pub triangles: usize,
    /// Their plan area, square lattice units, times two.
    pub doubled_area: i64,
}

/// The holes of the lattice's middle cell, by their first triangle.
#[must_use]
pub fn classify(lattice: &Lattice, states: &[State], area: &Area) -> Vec<Piece> {
    if states.iter().all(|s| s.hole().is_none()) {
        return Vec::new();
    }
    let regions = Regions::of(lattice, states);
    let perimeter = perimeter(lattice);
    let members = regions.members();
    members
        .iter()
        .filter_map(|triangles| {
            let hole = triangles.iter().filter_map(|&t| states[t].hole()).min()?;
            let class = class_of(lattice, states, area, &regions, &perimeter, triangles);
            let doubled_area = triangles.iter().map(|&t| doubled_area(lattice, t)).sum();
            Some(Piece { hole, class, triangles: triangles.len(), doubled_area })
        })
        .collect()
}

fn doubled_area(lattice: &Lattice, triangle: usize) -> i64 {
    let [a, b, c] = lattice.corners(triangle).map(|v| lattice.nodes[v]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Edge-connected regions of the cell: kept ones and left-out ones.
struct Regions {
    /// Region of each triangle; `usize::MAX` outside the cell.
    of: Vec<usize>,
    count: usize,
}

impl Regions {
    fn of(lattice: &Lattice, states: &[State]) -> Self {
        let mut of = vec![usize::MAX; states.len()];
        let mut count = 0;
        for start in (0..states.len()).filter(|t| lattice.is_inner(t / 2)) {
            if of[start] != usize::MAX {
                continue;
            }
            let mut stack = vec![start];
            of[start] = count;
            while let Some(t) = stack.pop() {
                let kept = states[t] == State::Kept;
                for other in lattice.neighbours(t).into_iter().flatten() {
                    let alike = (states[other] == State::Kept) == kept;
                    if alike && lattice.is_inner(other / 2) && of[other] == usize::MAX {
                        of[other] = count;
                        stack.push(other);
                    }
                }
            }
            count += 1;
        }
        Self { of, count }
    }

    fn members(&self) -> Vec<Vec<usize>> {
        let mut members = vec![Vec::new(); self.count];
        for (t, &region) in self.of.iter().enumerate().filter(|(_, r)| **r != usize::MAX) {
            members[region].push(t);
        }
        members
    }
}

/// The triangles along the cell's perimeter, counter-clockwise from the south-west corner, with the side they stand on.
fn perimeter(lattice: &Lattice) -> Vec<(usize, Side)> {
    let (first, n) = (lattice.halo(), lattice.quads());
    let last = first + n - 1;
    let along = |side: Side, k: usize| match side {
        Side::South => lattice.quad_index(first + k, first),
        Side::East => lattice.quad_index(last, first + k),
        Side::North => lattice.quad_index(last - k, last),
        Side::West => lattice.quad_index(first, last - k),
    };
    SIDES
        .iter()
        .flat_map(|&side| (0..n).map(move |k| (side, k)))
        .map(|(side, k)| (lattice.triangle_at(along(side, k), side), side))
        .collect()
}

fn class_of(
    lattice: &Lattice,
    states: &[State],
    area: &Area,
    regions: &Regions,
    perimeter: &[(usize, Side)],
    triangles: &[usize],
) -> Class {
    let region = regions.of[triangles[0]];
    let opened = |k: usize| regions.of[perimeter[k].0] == region;
    if !(0..perimeter.len()).any(opened) {
        return Class::Closed;
    }
    let sides_of_pieces = sides_of_stretches(states, perimeter, opened);
    let islands = has_island(lattice, regions, perimeter, triangles);
    let form = form_of(&sides_of_pieces, islands);
    let outside = |side: Side| !area.contains(beyond(lattice.cell(), side));
    if (0..perimeter.len()).any(|k| opened(k) && outside(perimeter[k].1)) {
        Class::External(form)
    } else {
        Class::Internal(form)
    }
}

fn form_of(sides_of_pieces: &[usize], has_island: bool) -> Form {
    match sides_of_pieces {
        [] if !has_island => Form::Hollow,
        [sides] if !has_island && *sides >= 1 => Form::SemiEnclosed,
        [one, other] if !has_island && *one >= 3 && *other >= 3 => Form::Crossing,
        _ => Form::Island,
    }
}

/// For each stretch of perimeter between openings: on how many sides it has kept triangles.
fn sides_of_stretches(
    states: &[State],
    perimeter: &[(usize, Side)],
    opened: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let length = perimeter.len();
    let starts = (0..length).filter(|&k| !opened(k) && opened((k + length - 1) % length));
    starts
        .map(|start| {
            let mut sides: Vec<Side> = (start..start + length)
                .map(|k| k % length)
                .take_while(|&k| !opened(k))
                .filter(|&k| states[perimeter[k].0] == State::Kept)
                .map(|k| perimeter[k].1)
                .collect();
            sides.sort_unstable();
            sides.dedup();
            sides.len()
        })
        .collect()
}

/// True if kept surface next to these triangles has no edge on the perimeter.
fn has_island(
    lattice: &Lattice,
    regions: &Regions,
    perimeter: &[(usize, Side)],
    triangles: &[usize],
) -> bool {
    let mut ashore = vec![false; regions.count];
    for (t, _) in perimeter {
        ashore[regions.of[*t]] = true;
    }
    let around = triangles.iter().flat_map(|&t| lattice.neighbours(t)).flatten();
    around.map(|t| regions.of[t]).any(|region| region != usize::MAX && !ashore[region])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_follow_pieces_and_the_sides_they_reach() {
        let cases: [(&[usize], bool, Form); 8] = [
            (&[], false, Form::Hollow),
            (&[4], false, Form::SemiEnclosed),
            (&[1], false, Form::SemiEnclosed),
            (&[3, 3], false, Form::Crossing),
            (&[4, 2], false, Form::Island),
            (&[3, 3, 1], false, Form::Island),
            (&[4], true, Form::Island),
            (&[], true, Form::Island),
        ];
        for (sides, island, form) in cases {
            assert_eq!(form_of(sides, island), form, "{sides:?} {island}");
        }
    }
}
