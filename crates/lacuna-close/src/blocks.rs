//! Blocks of a region: parts that are solved one after another, the rest held still (multiplicative Schwarz).

use glam::DVec2;
use lacuna_mesh::Fans;
use std::collections::BTreeMap;

/// A part of a triangulation with as much round it as the energy at its places reaches.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    /// Places of the whole: first the free ones, then those that are held.
    pub(crate) members: Vec<u32>,
    pub(crate) free: usize,
    /// Triangles in the numbering of `members`.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Splits places into parts of at most `limit` by halving along the longer side of their box; ties by number.
pub(crate) fn split(places: &[DVec2], limit: usize) -> Vec<Vec<u32>> {
    let mut parts = vec![];
    let mut open = vec![(0..places.len() as u32).collect::<Vec<u32>>()];
    while let Some(mut part) = open.pop() {
        if part.len() <= limit.max(1) {
            parts.push(part);
            continue;
        }
        let at = |v: &u32| places[*v as usize];
        let low = part.iter().map(at).fold(DVec2::INFINITY, DVec2::min);
        let high = part.iter().map(at).fold(DVec2::NEG_INFINITY, DVec2::max);
        let axis = usize::from((high - low).y > (high - low).x);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |a, b| at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(b)));
        let upper = part.split_off(middle);
        open.push(upper);
        open.push(part);
    }
    parts.iter_mut().for_each(|part| part.sort_unstable());
    parts
}

/// The block whose free places are `core` and `overlap` rings round it, with the complete triangles of their neighbours.
pub(crate) fn block(core: &[u32], overlap: usize, triangles: &[[u32; 3]], fans: &Fans) -> Block {
    let mut members = core.to_vec();
    let mut number: BTreeMap<u32, u32> = core.iter().copied().zip(0..).collect();
    let mut ring_start = 0;
    let mut grow = |members: &mut Vec<u32>| {
        let end = members.len();
        for k in ring_start..end {
            for &t in fans.of(members[k]) {
                for corner in triangles[t as usize] {
                    number.entry(corner).or_insert_with(|| {
                        members.push(corner);
                        members.len() as u32 - 1
                    });
                }
            }
        }
        ring_start = end;
    };
    (0..overlap).for_each(|_| grow(&mut members));
    let free = members.len();
    // A place's bending has all its neighbours in it; a neighbour's has theirs.
    grow(&mut members);
    let with_fan = members.len();
    grow(&mut members);
    let mut near: Vec<u32> = members[..with_fan].iter().flat_map(|&v| fans.of(v).iter().copied()).collect();
    near.sort_unstable();
    near.dedup();
    let triangles = near.iter().map(|&t| triangles[t as usize].map(|v| number[&v])).collect();
    Block { members, free, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_place_once() {
        let places: Vec<DVec2> =
            (0..1000).map(|k| DVec2::new(f64::from(k % 40), f64::from(k / 40))).collect();
        for limit in [1, 7, 300, 2000] {
            let parts = split(&places, limit);
            assert!(parts.iter().all(|p| p.len() <= limit));
            let mut all: Vec<u32> = parts.concat();
            all.sort_unstable();
            assert_eq!(all, (0..1000).collect::<Vec<u32>>());
        }
    }

    #[test]
    fn a_block_has_the_whole_fans_of_its_neighbours() {
        let n = 12u32;
        let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
        let triangles: Vec<[u32; 3]> =
            quads.flat_map(|k| [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]).collect();
        let fans = Fans::new((n * n) as usize, &triangles);
        let block = block(&[5 * n + 5, 5 * n + 6], 1, &triangles, &fans);
        assert_eq!(block.free, 2 + 8);
        let local = Fans::new(block.members.len(), &block.triangles);
        let neighbours: Vec<u32> = (0..block.free as u32)
            .flat_map(|v| local.of(v))
            .flat_map(|&t| block.triangles[t as usize])
            .collect();
        for v in neighbours {
            assert_eq!(local.of(v).len(), fans.of(block.members[v as usize]).len());
        }
    }
}
