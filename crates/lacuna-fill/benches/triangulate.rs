//! How fast the contour of a lake becomes triangles, in plan and with heights, by density.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3};
use lacuna_fill::{FillParams, fill, triangulate_in_plan};
use lacuna_mesh::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind};
use lacuna_solve::FaerSolver;

fn plan(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("triangulate in plan");
    group.sample_size(10);
    for vertices in [1_000, 10_000, 100_000] {
        let contour = lake(vertices);
        group.throughput(Throughput::Elements(vertices as u64));
        group.bench_with_input(BenchmarkId::new("graded", vertices), &contour, |b, contour| {
            b.iter(|| triangulate_in_plan(contour, &FillParams::default()).expect("a good contour"));
        });
    }
    let as_the_rim = FillParams { growth: 0.0, ..FillParams::default() };
    let contour = lake(1_000);
    group.throughput(Throughput::Elements(1_000));
    group.bench_with_input(BenchmarkId::new("as dense as the rim", 1_000), &contour, |b, contour| {
        b.iter(|| triangulate_in_plan(contour, &as_the_rim).expect("a good contour"));
    });
}

fn with_heights(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("fill");
    group.sample_size(10);
    for vertices in [1_000, 10_000] {
        let contour = lake(vertices);
        group.throughput(Throughput::Elements(vertices as u64));
        group.bench_with_input(BenchmarkId::new("graded", vertices), &contour, |b, contour| {
            b.iter(|| fill(contour, &FillParams::default(), &FaerSolver).expect("a good contour"));
        });
    }
}

/// A lake of lobes with uneven steps along its shore, 10 cm in the mean.
fn lake(vertices: usize) -> Contour {
    let radius = 0.1 * vertices as f64 / 8.0;
    let place = |i: usize| {
        let jitter = 0.35 * libm::sin(12.9898 * i as f64);
        let t = std::f64::consts::TAU * (i as f64 + jitter) / vertices as f64;
        let r = radius * (1.0 + 0.25 * libm::sin(3.0 * t) + 0.1 * libm::sin(11.0 * t));
        let p = DVec2::new(r * libm::cos(t), r * libm::sin(t));
        p.extend(0.02 * p.x + 0.5 * libm::sin(p.y / radius * 4.0))
    };
    let places: Vec<DVec3> = (0..vertices).map(place).collect();
    let length = |i: usize| places[i % vertices].distance(places[(i + 1) % vertices]);
    let vertices = (0..vertices)
        .map(|i| ContourVertex {
            position: places[i],
            spacing_m: 0.5 * (length(i) + length(i + vertices - 1)),
        })
        .collect::<Vec<_>>();
    let edges = vec![ContourEdge { kind: EdgeKind::Rim, apex: None }; vertices.len()];
    Contour { outer: ContourRing { vertices, edges }, ..Contour::default() }
}

criterion_group!(benches, plan, with_heights);
criterion_main!(benches);
