//! Faces of a tile with the bytes that hold them.

use std::ops::Range;

/// Faces of one tile, whatever its format.
#[derive(Clone, Debug, Default)]
pub(super) struct TileFaces {
    /// Positions in file order.
    pub(super) positions: Vec<[f64; 3]>,
    /// Corners of all faces one after another; an index out of range marks a broken face, which is left alone.
    pub(super) corners: Vec<usize>,
    /// Where each face's corners end.
    pub(super) ends: Vec<usize>,
    /// The bytes of each face: a row, or lines.
    pub(super) bytes: Vec<Range<usize>>,
    /// The digits of a header's face count, if there is one.
    pub(super) count: Option<Range<usize>>,
}

impl TileFaces {
    /// Number of faces.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    fn corners_of(&self, face: usize) -> &[usize] {
        let start = if face == 0 { 0 } else { self.ends[face - 1] };
        &self.corners[start..self.ends[face]]
    }

    /// Mean of the face's corners; `None` if it has none, or broken ones.
    pub(super) fn centroid(&self, face: usize) -> Option<[f64; 3]> {
        let corners = self.corners_of(face);
        let mut sum = [0.0; 3];
        for &corner in corners {
            let position = self.positions.get(corner)?;
            (0..3).for_each(|k| sum[k] += position[k]);
        }
        let mean = sum.map(|k| k / corners.len() as f64);
        mean.iter().all(|k| k.is_finite()).then_some(mean)
    }

    /// Area in plan, square metres.
    pub(super) fn plan_area(&self, face: usize) -> f64 {
        let corners = self.corners_of(face);
        let n = corners.len();
        let cross = |k: usize| {
            let (a, b) = (self.positions[corners[k]], self.positions[corners[(k + 1) % n]]);
            a[0] * b[1] - a[1] * b[0]
        };
        (0..n).map(cross).sum::<f64>().abs() / 2.0
    }

    /// Vertices that only removed faces use, with the hole of the first of these.
    pub(super) fn lost_vertices(&self, hole_of: &[Option<usize>]) -> Vec<(usize, usize)> {
        let known = self.positions.len();
        let mut lost: Vec<Option<usize>> = vec![None; known];
        let mut used = vec![false; known];
        for face in 0..self.len() {
            for &corner in self.corners_of(face).iter().filter(|&&c| c < known) {
                match hole_of[face] {
                    None => used[corner] = true,
                    Some(hole) => lost[corner] = lost[corner].or(Some(hole)),
                }
            }
        }
        (0..lost.len()).filter(|&v| !used[v]).filter_map(|v| Some((v, lost[v]?))).collect()
    }

    /// The file without some faces.
    pub(super) fn without(&self, bytes: &[u8], is_gone: impl Fn(usize) -> bool) -> Vec<u8> {
        let mut kept = Vec::with_capacity(bytes.len());
        let mut copied = 0;
        if let Some(count) = &self.count {
            let left = (0..self.len()).filter(|&f| !is_gone(f)).count();
            kept.extend(&bytes[..count.start]);
            kept.extend(left.to_string().as_bytes());
            copied = count.end;
        }
        for gone in (0..self.len()).filter(|&f| is_gone(f)).map(|f| self.bytes[f].clone()) {
            kept.extend(&bytes[copied..gone.start]);
            copied = gone.end;
        }
        kept.extend(&bytes[copied..]);
        kept
    }
}
