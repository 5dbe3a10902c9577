//! Contour vertices at one place become one vertex.

use crate::FillError;
use lacuna_mesh::Contour;
use std::borrow::Cow;

/// A contour, and which of its vertices are one.
#[derive(Clone, Debug)]
pub(crate) struct Welded<'a> {
    /// Rings as given; support triangles and forbidden edges name the first vertex of each place.
    pub(crate) contour: Cow<'a, Contour>,
    /// For each contour vertex the first one at its place.
    pub(crate) first_at_place: Vec<u32>,
    /// True if rings touch, or a ring touches itself, in a vertex.
    pub(crate) touches: bool,
}

/// Joins the vertices of rings that touch, and of rings that touch themselves.
///
/// # Errors
/// [`FillError::BadRings`] if an edge joins a place with itself, or two edges of the contour join the same two places.
pub(crate) fn weld(contour: &Contour) -> Result<Welded<'_>, FillError> {
    let first_at_place = contour.first_at_place();
    let touches = first_at_place.iter().zip(0u32..).any(|(&first, v)| first != v);
    if !touches {
        return Ok(Welded { contour: Cow::Borrowed(contour), first_at_place, touches });
    }
    check_edges(contour, &first_at_place)?;
    let place = |v: u32| first_at_place.get(v as usize).copied().unwrap_or(v);
    let mut joined = contour.clone();
    joined.support.triangles.iter_mut().flatten().for_each(|v| *v = place(*v));
    for pair in &mut joined.forbidden_edges {
        *pair = pair.map(place);
        pair.sort_unstable();
    }
    joined.forbidden_edges.sort_unstable();
    joined.forbidden_edges.dedup();
    Ok(Welded { contour: Cow::Owned(joined), first_at_place, touches })
}

fn check_edges(contour: &Contour, first_at_place: &[u32]) -> Result<(), FillError> {
    let mut edges = vec![];
    let mut first = 0;
    for ring in contour.rings() {
        let n = ring.vertices.len();
        for i in 0..n {
            let mut ends = [first + i, first + (i + 1) % n].map(|v| first_at_place[v]);
            ends.sort_unstable();
            edges.push(ends);
        }
        first += n;
    }
    let bad = |what: String| Err(FillError::BadRings { what });
    if let Some([v, _]) = edges.iter().find(|[a, b]| a == b) {
        return bad(format!("the edge at contour vertex {v} has no length"));
    }
    edges.sort_unstable();
    match edges.windows(2).find(|pair| pair[0] == pair[1]) {
        Some([[a, b], _]) => bad(format!("two edges join contour vertices {a} and {b}")),
        _ => Ok(()),
    }
}

impl Welded<'_> {
    /// The first contour vertex at the place of `v`; `v` itself if it is none of the contour.
    pub(crate) fn first(&self, v: u32) -> u32 {
        self.first_at_place.get(v as usize).copied().unwrap_or(v)
    }

    /// True if the mesh already joins the places of these two contour vertices, or they are one place.
    pub(crate) fn is_joined(&self, a: u32, b: u32) -> bool {
        let (a, b) = (self.first(a), self.first(b));
        a == b || self.contour.forbidden_edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// Pairs of places of `chain` (smaller first, sorted) that must not be joined.
    pub(crate) fn forbidden_in(&self, chain: &[u32]) -> Vec<[u32; 2]> {
        if !self.touches && self.contour.forbidden_edges.is_empty() {
            return vec![];
        }
        let count = chain.len() as u32;
        let pairs = (0..count).flat_map(|p| (p + 1..count).map(move |q| [p, q]));
        pairs.filter(|&[p, q]| self.is_joined(chain[p as usize], chain[q as usize])).collect()
    }
}
