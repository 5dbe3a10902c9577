//! Contours from `testdata/contours`, the changes they are put through, and what every patch must be.

#![allow(dead_code, unreachable_pub)] // each test file uses its own part

use glam::{DQuat, DVec2, DVec3};
use lacuna_fill::Filled;
use lacuna_mesh::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind};
use std::collections::BTreeMap;
use std::path::Path;

/// A contour of the table.
pub struct Case {
    pub name: String,
    pub expect: String,
    pub contour: Contour,
}

/// All contours of `testdata/contours`, by name.
pub fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/contours");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| read(file)).collect()
}

pub fn case(name: &str) -> Contour {
    cases().into_iter().find(|c| c.name == name).unwrap().contour
}

fn read(file: &Path) -> Case {
    let (mut expect, mut rings) = (String::new(), Vec::<Vec<(DVec3, f64, EdgeKind)>>::new());
    for line in std::fs::read_to_string(file).unwrap().lines() {
        let words: Vec<&str> = line.split('#').next().unwrap().split_whitespace().collect();
        match words[..] {
            [] => {}
            ["expect", filler] => expect = filler.to_owned(),
            ["ring"] => rings.push(vec![]),
            [x, y, z, spacing, kind] => {
                let number = |w: &str| w.parse::<f64>().unwrap();
                let kind = if kind == "border" { EdgeKind::Border } else { EdgeKind::Rim };
                let vertex = (DVec3::new(number(x), number(y), number(z)), number(spacing), kind);
                rings.last_mut().unwrap().push(vertex);
            }
            _ => panic!("{}: {line}", file.display()),
        }
    }
    let mut rings = rings.into_iter().map(|r| ring(&r));
    let outer = rings.next().unwrap();
    let contour = Contour { outer, inner: rings.collect(), ..Contour::default() };
    Case { name: file.file_stem().unwrap().to_string_lossy().into_owned(), expect, contour }
}

fn ring(vertices: &[(DVec3, f64, EdgeKind)]) -> ContourRing {
    ContourRing {
        vertices: vertices.iter().map(|v| ContourVertex { position: v.0, spacing_m: v.1 }).collect(),
        edges: vertices.iter().map(|v| ContourEdge { kind: v.2, apex: None }).collect(),
    }
}

/// A contour of rim edges through the given places; spacing from the edges.
pub fn contour_of(rings: &[Vec<DVec3>]) -> Contour {
    let mut rings = rings.iter().map(|r| {
        let vertices: Vec<_> = r.iter().map(|&p| (p, 0.0, EdgeKind::Rim)).collect();
        ring(&vertices)
    });
    let outer = rings.next().unwrap();
    Contour { outer, inner: rings.collect(), ..Contour::default() }
}

/// The contour with every position changed by `f`.
pub fn mapped(contour: &Contour, f: impl Fn(DVec3) -> DVec3) -> Contour {
    let mut changed = contour.clone();
    for ring in std::iter::once(&mut changed.outer).chain(&mut changed.inner) {
        ring.vertices.iter_mut().for_each(|v| v.position = f(v.position));
        ring.edges.iter_mut().for_each(|e| e.apex = e.apex.map(&f));
    }
    changed.support.vertices.iter_mut().for_each(|p| *p = f(*p));
    changed
}

pub fn turned(contour: &Contour, degrees: f64) -> Contour {
    let turn = DQuat::from_rotation_z(degrees.to_radians());
    mapped(contour, |p| turn * p)
}

/// Mirrored in x, rings walked the other way so that the hole stays on the left.
pub fn mirrored(contour: &Contour) -> Contour {
    let mut changed = mapped(contour, |p| DVec3::new(-p.x, p.y, p.z));
    for ring in std::iter::once(&mut changed.outer).chain(&mut changed.inner) {
        ring.vertices.reverse();
        ring.edges.reverse();
        ring.edges.rotate_left(1);
    }
    changed
}

/// Rings start `by` vertices later.
pub fn started_at(contour: &Contour, by: usize) -> Contour {
    let mut changed = contour.clone();
    for ring in std::iter::once(&mut changed.outer).chain(&mut changed.inner) {
        let by = by % ring.vertices.len();
        ring.vertices.rotate_left(by);
        ring.edges.rotate_left(by);
    }
    changed
}

/// Asserts what `fill` promises beyond its own check: counts, orientation in plan, area, edges used, quality facts.
/// Contour vertices at one place are one.
pub fn assert_sound(name: &str, contour: &Contour, done: &Filled) {
    let mut points = contour.positions();
    points.extend(&done.patch.vertices);
    let first = first_at_place(&points);
    let place = |v: u32| first[v as usize];
    let mut edges = BTreeMap::new();
    for &triangle in &done.patch.triangles {
        let [a, b, c] = triangle.map(place);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert((from, to), ()).is_none(), "{name}: edge {from}-{to} is used twice");
        }
    }
    let rings = numbered_rings(contour, &first);
    for ring in &rings {
        for (i, &from) in ring.iter().enumerate() {
            let to = ring[(i + 1) % ring.len()];
            assert!(edges.contains_key(&(from, to)), "{name}: rim edge {from}-{to} is open");
            assert!(!edges.contains_key(&(to, from)), "{name}: rim edge {from}-{to} has two triangles");
        }
    }
    let open = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a))).count();
    assert_eq!(open, contour.len(), "{name}: inner edges are open");
    let undirected = (edges.len() + open) / 2;
    let places = first.iter().enumerate().filter(|&(v, &f)| v as u32 == f).count();
    let euler = places as i64 - undirected as i64 + done.patch.triangles.len() as i64;
    // A plane set in one piece has as many holes as the rings have clockwise loops.
    let islands = rings.iter().flat_map(|r| simple_loops(r)).filter(|l| is_clockwise(l, &points)).count();
    let islands = if done.in_plan { islands } else { contour.inner.len() };
    assert_eq!(euler, 1 - islands as i64, "{name}: Euler number");
    for pair in &contour.forbidden_edges {
        let [a, b] = pair.map(place);
        let is_contour = edges.contains_key(&(a, b)) != edges.contains_key(&(b, a));
        assert!(is_contour || !edges.contains_key(&(a, b)), "{name}: existing edge {pair:?} is used");
    }
    if done.in_plan {
        assert_plan_area(name, contour, done, &points);
    }
    assert!(done.patch.vertices.iter().all(|p| p.is_finite()), "{name}");
}

/// For each point the first one with the same coordinates.
fn first_at_place(points: &[DVec3]) -> Vec<u32> {
    let mut known = BTreeMap::new();
    let bits = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    points.iter().zip(0..).map(|(p, v)| *known.entry(bits(p)).or_insert(v)).collect()
}

/// The places of each ring's vertices.
fn numbered_rings(contour: &Contour, first: &[u32]) -> Vec<Vec<u32>> {
    let mut places = first.iter().copied();
    contour.rings().map(|r| places.by_ref().take(r.vertices.len()).collect()).collect()
}

/// Cuts a ring into loops without repeated places.
fn simple_loops(ring: &[u32]) -> Vec<Vec<u32>> {
    let (mut walk, mut loops) = (Vec::<u32>::new(), vec![]);
    for &v in ring.iter().chain(&ring[..1]) {
        if let Some(at) = walk.iter().position(|&w| w == v) {
            loops.push(walk.split_off(at));
        }
        walk.push(v);
    }
    loops
}

fn is_clockwise(ring: &[u32], points: &[DVec3]) -> bool {
    let at = |v: u32| points[v as usize].truncate() - points[ring[0] as usize].truncate();
    ring.windows(2).map(|w| at(w[0]).perp_dot(at(w[1]))).sum::<f64>() < 0.0
}

/// Triangles seen from above must cover the outer ring less the islands exactly once.
fn assert_plan_area(name: &str, contour: &Contour, done: &Filled, points: &[DVec3]) {
    let area = |ring: &[DVec2]| {
        let o = ring[0];
        ring.windows(2).map(|w| (w[0] - o).perp_dot(w[1] - o)).sum::<f64>() / 2.0
    };
    let wanted: f64 = contour
        .rings()
        .map(|r| area(&r.vertices.iter().map(|v| v.position.truncate()).collect::<Vec<_>>()))
        .sum();
    let mut covered = 0.0;
    for (t, corners) in done.patch.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|v| points[v as usize].truncate());
        let doubled = (b - a).perp_dot(c - a);
        let vertical = done.vertical.contains(&(t as u32));
        assert!(vertical || doubled > 0.0, "{name}: triangle {t} is turned over");
        covered += doubled / 2.0;
    }
    assert!((covered - wanted).abs() <= 1e-9 * wanted.abs(), "{name}: covers {covered} of {wanted} m2");
}
