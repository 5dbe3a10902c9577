//! How fast boundaries, loops and components are found: 2 million triangles with dug holes, numbered as tiles are (charts
//! of a texture atlas, one after the other), as one grid, and at random.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use lacuna_mesh::{TriMesh, boundary, components, loops};

/// Quads along a side.
const SIDE: u32 = 1000;

fn all(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("boundary");
    group.sample_size(10);
    for (name, mesh) in [
        ("one chart", grid(SIDE)),
        ("charts of 64 x 64 quads", grid(64)),
        ("charts of 16 x 16 quads", grid(16)),
        ("vertices in random order", shuffled(grid(SIDE))),
    ] {
        group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
        group.bench_function(name, |b| b.iter(|| boundary(&mesh)));
    }
    let mesh = grid(64);
    let found = boundary(&mesh);
    group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
    group.bench_function("loops", |b| b.iter(|| loops(&found)));
    group.bench_function("components", |b| {
        b.iter(|| components(&mesh, &found));
    });
}

/// A hilly grid with a 4 x 4 hole in every 64 x 64 quads; vertices are split between charts.
fn grid(chart: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    let starts = || (0..SIDE).step_by(chart as usize);
    for (x0, y0) in starts().flat_map(|x| starts().map(move |y| (x, y))) {
        let (x1, y1) = ((x0 + chart).min(SIDE), (y0 + chart).min(SIDE));
        let first = mesh.positions.len() as u32;
        let row = x1 - x0 + 1;
        mesh.positions.extend((y0..=y1).flat_map(|y| (x0..=x1).map(move |x| place(x, y))));
        for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
            if x % 64 < 60 || y % 64 < 60 {
                let v = first + (y - y0) * row + x - x0;
                mesh.triangles.extend([[v, v + 1, v + row + 1], [v, v + row + 1, v + row]]);
            }
        }
    }
    mesh
}

fn place(x: u32, y: u32) -> DVec3 {
    DVec3::new(f64::from(x) * 0.25, f64::from(y) * 0.25, f64::from((x * 7 + y * 13) % 101) * 0.01)
}

/// The same mesh with its vertices renumbered at random (xorshift, fixed seed).
fn shuffled(mesh: TriMesh) -> TriMesh {
    let mut number: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    for i in (1..number.len()).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        number.swap(i, (state % (i as u64 + 1)) as usize);
    }
    let mut positions = mesh.positions.clone();
    mesh.positions.iter().zip(&number).for_each(|(&p, &n)| positions[n as usize] = p);
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| number[v as usize])).collect();
    TriMesh { positions, triangles }
}

criterion_group!(benches, all);
criterion_main!(benches);
