//! How fast the surface of a lake is fitted, by the number of places; and in blocks, as very large lakes are.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec2;
use lacuna_close::{Datum, FieldParams, Region, height_field};
use lacuna_solve::FaerSolver;

fn all(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("height field");
    group.sample_size(10);
    for half in [16, 32, 64] {
        let region = region(half);
        let places = region.places.len();
        group.throughput(Throughput::Elements(places as u64));
        group.bench_with_input(BenchmarkId::new("at once", places), &region, |b, region| {
            b.iter(|| height_field(region, &FieldParams::default(), &FaerSolver).expect("a good region"));
        });
    }
    let region = region(64);
    let places = region.places.len();
    let few = FieldParams { max_unknowns: places / 4, ..FieldParams::default() };
    group.throughput(Throughput::Elements(places as u64));
    group.bench_with_input(BenchmarkId::new("coarse, then blocks", places), &region, |b, region| {
        b.iter(|| height_field(region, &few, &FaerSolver).expect("a good region"));
    });
}

/// A square of shaken places 1 m apart on hills, 2 `half` wide, with a round lake of 0.6 of its width in the middle.
fn region(half: i32) -> Region {
    let (side, radius_m) = (2 * half + 1, 0.6 * f64::from(half));
    let shake = |k: i32| 0.15 * libm::sin(f64::from(k) * 12.9898);
    let place = |k: i32| {
        let even = DVec2::new(f64::from(k % side - half), f64::from(k / side - half));
        even + DVec2::new(shake(k), shake(k + 991))
    };
    let places: Vec<DVec2> = (0..side * side).map(place).collect();
    let ground = |p: DVec2| 2.0 * libm::sin(0.13 * p.x + 0.4) + 1.5 * libm::cos(0.11 * p.y - 0.2);
    let datum = |p: DVec2| {
        let is_exact = p.length() < radius_m + 1.5;
        (p.length() >= radius_m).then(|| Datum { height_m: ground(p), weight: 1.0, is_exact })
    };
    let quads = (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| j * side + i));
    let corners = |k: i32| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]];
    Region {
        data: places.iter().map(|&p| datum(p)).collect(),
        places,
        triangles: quads.flat_map(corners).map(|t| t.map(|v| v as u32)).collect(),
        edge_m: 1.0,
        radius_m,
    }
}

criterion_group!(benches, all);
criterion_main!(benches);
