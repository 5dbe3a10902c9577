//! The best-fit plane of a contour, for facades and tilted holes.

use crate::frame::Frame;
use crate::lift::vector_area;
use glam::{DVec2, DVec3};
use lacuna_mesh::{Contour, signed_area};

/// The frame square to a contour's best-fit plane, or `None` if the contour strays too far from it (algorithms E.4).
///
/// Normal: the vector area of the outer ring, which no choice of first vertex changes, so the contour runs
/// counter-clockwise in the frame. Accepted iff no vertex is farther from the plane through the mean than a quarter of
/// the smaller of: the ring's extent square to its long axis, the radius of a disk of its area halved by its
/// perimeter (twice area over perimeter).
pub(crate) fn best_fit_frame(contour: &Contour) -> Option<Frame> {
    let outer: Vec<DVec3> = contour.outer.vertices.iter().map(|v| v.position).collect();
    let normal = vector_area(&outer).try_normalize()?;
    let all = contour.positions();
    let mean = all.iter().map(|p| *p - all[0]).sum::<DVec3>() / all.len() as f64 + all[0];
    let frame = Frame::plane(mean, normal);
    let flat: Vec<DVec3> = outer.iter().map(|&p| frame.local(p)).collect();
    let plane: Vec<DVec2> = flat.iter().map(|p| p.truncate()).collect();
    let area = signed_area(&plane);
    let perimeter = lacuna_mesh::perimeter(&plane);
    let inscribed = 2.0 * area / perimeter;
    let extent = |f: &dyn Fn(&DVec2) -> f64| {
        let (low, high) =
            plane.iter().map(f).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    let width = extent(&|p| p.x).min(extent(&|p| p.y));
    let farthest = all.iter().map(|&p| frame.local(p).z.abs()).fold(0.0, f64::max);
    (farthest <= 0.25 * width.min(inscribed)).then_some(frame)
}
