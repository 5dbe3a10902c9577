//! Patches: a sound one passes, and each way to spoil it is named.

use glam::DVec3;
use lacuna_mesh::{
    Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind, Patch, PatchDefect, PlanView, check_patch,
};

fn ring(places: &[[f64; 2]]) -> ContourRing {
    let vertices = places
        .iter()
        .map(|p| ContourVertex { position: DVec3::new(p[0], p[1], p[0] * 0.25), spacing_m: 1.0 });
    let edges = vec![ContourEdge { kind: EdgeKind::Rim, apex: None }; places.len()];
    ContourRing { vertices: vertices.collect(), edges }
}

/// A square hole of 4 m.
fn square() -> Contour {
    Contour { outer: ring(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]), ..Contour::default() }
}

/// The square filled by a fan round a vertex in its middle.
fn fan() -> Patch {
    Patch {
        vertices: vec![DVec3::new(2.0, 2.0, 1.0)],
        triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    }
}

/// The square with a square island, which runs clockwise.
fn framed() -> (Contour, Patch) {
    let inner = vec![ring(&[[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]])];
    let triangles =
        vec![[0, 1, 7], [0, 7, 4], [1, 2, 6], [1, 6, 7], [2, 3, 5], [2, 5, 6], [3, 0, 4], [3, 4, 5]];
    (Contour { inner, ..square() }, Patch { vertices: vec![], triangles })
}

#[test]
fn sound_patches_pass() {
    let facts = check_patch(&square(), &fan(), PlanView::Judged).expect("a fan");
    assert_eq!((facts.vertices, facts.edges, facts.triangles), (5, 8, 4));
    let (contour, patch) = framed();
    let facts = check_patch(&contour, &patch, PlanView::Judged).expect("a frame");
    assert_eq!((facts.vertices, facts.edges, facts.triangles), (8, 16, 8));
    assert!(facts.area_m2 > 12.0);
    let plain = Patch { vertices: vec![], triangles: vec![[0, 1, 2], [0, 2, 3]] };
    assert!(check_patch(&square(), &plain, PlanView::Judged).is_ok());
}

#[test]
fn each_defect_is_named() {
    let spoilt = |change: fn(&mut Patch)| {
        let mut patch = fan();
        change(&mut patch);
        patch
    };
    let two = |triangles: &[[u32; 3]]| Patch { vertices: vec![], triangles: triangles.to_vec() };
    let cases = [
        ("not finite", spoilt(|p| p.vertices[0].z = f64::NAN), PatchDefect::NotFinite { vertex: 4 }),
        (
            "out of range",
            spoilt(|p| p.triangles[2][1] = 9),
            PatchDefect::OutOfRange { triangle: 2, vertex: 9, count: 5 },
        ),
        ("spare vertex", spoilt(|p| p.vertices.push(DVec3::ONE)), PatchDefect::Unused { vertex: 5 }),
        ("contour vertex left out", two(&[[0, 1, 2]]), PatchDefect::Unused { vertex: 3 }),
        (
            "flat",
            spoilt(|p| p.vertices[0] = DVec3::new(2.0, 1e-7, 0.5)),
            PatchDefect::Degenerate { triangle: 0 },
        ),
        ("corner twice", spoilt(|p| p.triangles.push([0, 0, 1])), PatchDefect::Degenerate { triangle: 4 }),
        ("turned over", spoilt(|p| p.triangles[1] = [2, 1, 4]), PatchDefect::TurnedOver { triangle: 1 }),
        ("outside", spoilt(|p| p.vertices[0].x = 5.0), PatchDefect::TurnedOver { triangle: 1 }),
        ("repeated", spoilt(|p| p.triangles.push([2, 4, 1])), PatchDefect::Duplicate { first: 1, second: 4 }),
        (
            "missing",
            spoilt(|p| _ = p.triangles.pop()),
            PatchDefect::ContourEdge { from: 3, to: 0, along: 0, against: 0 },
        ),
        (
            "overlapping",
            two(&[[0, 1, 2], [0, 2, 3], [0, 1, 3]]),
            PatchDefect::ContourEdge { from: 0, to: 1, along: 2, against: 0 },
        ),
    ];
    for (name, patch, expected) in cases {
        assert_eq!(check_patch(&square(), &patch, PlanView::Judged), Err(expected), "{name}");
    }
}

#[test]
fn defects_that_need_another_contour_are_named() {
    let plain = Patch { vertices: vec![], triangles: vec![[0, 1, 2], [0, 2, 3]] };
    let forbidden = Contour { forbidden_edges: vec![[0, 2]], ..square() };
    let expected = Err(PatchDefect::ForbiddenEdge { from: 0, to: 2 });
    assert_eq!(check_patch(&forbidden, &plain, PlanView::Judged), expected);

    let mut reversed = square();
    reversed.outer.vertices.reverse();
    let expected = Err(PatchDefect::ContourEdge { from: 0, to: 1, along: 0, against: 1 });
    let turned = Patch { vertices: vec![], triangles: vec![[0, 2, 1], [0, 3, 2]] };
    assert_eq!(check_patch(&reversed, &turned, PlanView::Judged), expected);

    // A tetrahedron that floats beside a sound patch, or stands on one of its vertices, has only sound edges.
    let mut more = plain.clone();
    more.vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    more.triangles.extend([[4, 6, 5], [4, 5, 7], [5, 6, 7], [6, 4, 7]]);
    let expected = Err(PatchDefect::Separate { triangle: 2 });
    assert_eq!(check_patch(&square(), &more, PlanView::NotJudged), expected);
    let mut standing = plain;
    standing.vertices = vec![DVec3::X, DVec3::Y, DVec3::Z];
    standing.triangles.extend([[2, 5, 4], [2, 4, 6], [4, 5, 6], [5, 2, 6]]);
    let expected = Err(PatchDefect::Pinched { vertex: 2, fans: 2, expected: 1 });
    assert_eq!(check_patch(&square(), &standing, PlanView::NotJudged), expected);

    let (contour, patch) = torus_without_a_triangle();
    let expected = Err(PatchDefect::EulerNumber { found: -1, expected: 1 });
    assert_eq!(check_patch(&contour, &patch, PlanView::NotJudged), expected);
    assert!(check_patch(&Contour::default(), &Patch::default(), PlanView::NotJudged).is_err());
}

/// The torus of seven vertices (Moebius), whose first triangle is the hole.
fn torus_without_a_triangle() -> (Contour, Patch) {
    let places = [[0.0, 0.0], [2.0, 0.5], [1.0, 3.0], [5.0, 1.0], [7.0, 4.0], [3.0, 6.0], [8.0, 8.5]];
    let triangles =
        (0..7).flat_map(|i| [[i, i + 1, i + 3], [i, i + 3, i + 2]].map(|t| t.map(|v: u32| v % 7)));
    let number = |v: u32| [0, 2, 3, 1, 4, 5, 6][v as usize];
    let triangles = triangles.skip(1).map(|t| t.map(number)).collect();
    let vertices = [2, 4, 5, 6].map(|v: usize| DVec3::new(places[v][0], places[v][1], 0.1 * (v * v) as f64));
    let contour = Contour { outer: ring(&[places[0], places[3], places[1]]), ..Contour::default() };
    (contour, Patch { vertices: vertices.to_vec(), triangles })
}

/// Sound patches over rings that touch, and their number of triangles: each touching vertex stands in two rings, or
/// twice in one.
fn touching() -> Vec<(&'static str, Contour, Patch)> {
    let framed =
        |inner: &[&[[f64; 2]]]| Contour { inner: inner.iter().map(|r| ring(r)).collect(), ..square() };
    let alone = |places: &[[f64; 2]]| Contour { outer: ring(places), ..Contour::default() };
    let patch = |triangles: &[[u32; 3]]| Patch { vertices: vec![], triangles: triangles.to_vec() };
    vec![
        (
            "an island at a corner",
            framed(&[&[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]]]),
            patch(&[[4, 1, 6], [1, 2, 6], [6, 2, 5], [5, 2, 3], [0, 5, 3]]),
        ),
        (
            "an island from corner to corner",
            framed(&[&[[0.0, 0.0], [1.0, 3.0], [4.0, 4.0], [3.0, 1.0]]]),
            patch(&[[0, 1, 7], [1, 2, 7], [4, 5, 3], [5, 6, 3]]),
        ),
        (
            "two islands that touch",
            framed(&[&[[2.0, 2.0], [1.0, 1.0], [1.0, 3.0]], &[[2.0, 2.0], [3.0, 3.0], [3.0, 1.0]]]),
            patch(&[
                [0, 1, 5],
                [1, 9, 5],
                [5, 9, 7],
                [1, 2, 9],
                [2, 8, 9],
                [2, 3, 8],
                [8, 3, 6],
                [8, 6, 4],
                [3, 0, 6],
                [0, 5, 6],
            ]),
        ),
        (
            "a ring of two lobes",
            alone(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 2.0], [0.0, 2.0]]),
            patch(&[[0, 1, 2], [0, 5, 6], [2, 3, 4]]),
        ),
        (
            "a ring round an island that hangs on it",
            alone(&[[0.0, 0.0], [4.0, 0.0], [2.0, 4.0], [0.0, 0.0], [1.5, 2.0], [2.0, 1.0]]),
            patch(&[[0, 1, 5], [5, 1, 2], [5, 2, 4], [3, 4, 2]]),
        ),
    ]
}

#[test]
fn rings_may_touch_in_a_vertex() {
    for (name, contour, patch) in touching() {
        let facts = check_patch(&contour, &patch, PlanView::Judged);
        assert_eq!(facts.map(|f| f.triangles), Ok(patch.triangles.len()), "{name}");
        // Whatever vertex of a place a triangle names.
        let first = contour.first_at_place();
        let mut renamed = patch.clone();
        renamed.triangles.iter_mut().flatten().for_each(|v| *v = first[*v as usize]);
        assert_ne!(renamed, patch, "{name}");
        assert!(check_patch(&contour, &renamed, PlanView::Judged).is_ok(), "{name}");
    }
}

#[test]
fn touching_rings_hide_no_defect() {
    for (name, contour, patch) in touching() {
        for t in 0..patch.triangles.len() {
            let mut less = patch.clone();
            less.triangles.remove(t);
            let result = check_patch(&contour, &less, PlanView::Judged);
            assert!(
                matches!(
                    result,
                    Err(PatchDefect::ContourEdge { .. }
                        | PatchDefect::InnerEdge { .. }
                        | PatchDefect::Unused { .. })
                ),
                "{name} without {t}: {result:?}"
            );
        }
        let mut twice = patch.clone();
        let first = contour.first_at_place();
        twice.triangles.push(patch.triangles[0].map(|v| first[v as usize]));
        let expected = PatchDefect::Duplicate { first: 0, second: patch.triangles.len() };
        assert_eq!(check_patch(&contour, &twice, PlanView::Judged), Err(expected), "{name}");
    }
    // The lobes share the inner edge from 0 to the touching vertex, whichever of its two names the pair has.
    let (_, contour, patch) = touching().remove(3);
    for pair in [[0, 2], [0, 5]] {
        let contour = Contour { forbidden_edges: vec![pair], ..contour.clone() };
        let expected = PatchDefect::ForbiddenEdge { from: 0, to: 2 };
        assert_eq!(check_patch(&contour, &patch, PlanView::Judged), Err(expected));
    }
    let (_, contour, mut patch) = touching().remove(3);
    patch.triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 6]];
    assert!(check_patch(&contour, &patch, PlanView::NotJudged).is_err());
    // An island touches in one of its vertices: a fan that closes there joins nothing.
    let (_, contour, mut patch) = touching().remove(0);
    patch.vertices = vec![DVec3::X, DVec3::Y, DVec3::Z];
    patch.triangles.extend([[4, 8, 7], [4, 7, 9], [7, 8, 9], [8, 4, 9]]);
    let expected = PatchDefect::Pinched { vertex: 0, fans: 3, expected: 2 };
    assert_eq!(check_patch(&contour, &patch, PlanView::NotJudged), Err(expected));
}

#[test]
fn an_edge_walked_twice_is_no_contour() {
    let there_and_back = ring(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [4.0, 4.0], [0.0, 4.0]]);
    let contour = Contour { outer: there_and_back, ..Contour::default() };
    let triangles = vec![[0, 1, 3], [1, 2, 3], [3, 4, 5], [5, 0, 3]];
    let result = check_patch(&contour, &Patch { vertices: vec![], triangles }, PlanView::Judged);
    assert!(matches!(result, Err(PatchDefect::ContourEdge { .. })), "{result:?}");
}

#[test]
fn what_is_not_judged_in_plan_may_overhang() {
    let mut patch = fan();
    patch.vertices[0].x = 5.0;
    assert!(check_patch(&square(), &patch, PlanView::NotJudged).is_ok());
}

#[test]
fn patches_far_away_are_judged_the_same() {
    let (mut contour, patch) = framed();
    let shift = DVec3::new(5e5, 5e5, 100.0);
    for ring in std::iter::once(&mut contour.outer).chain(&mut contour.inner) {
        ring.vertices.iter_mut().for_each(|v| v.position += shift);
    }
    assert!(check_patch(&contour, &patch, PlanView::Judged).is_ok());
}
