//! Prints how fast boundaries are found: a grid of 6 million triangles with dug holes, as one chart, in texture charts,
//! and with its vertices in random order.
#![allow(clippy::print_stdout)] // it is what an example is for

use glam::DVec3;
use lacuna_mesh::{TriMesh, boundary, components, loops};
use std::sync::LazyLock;
use std::time::Instant;

const SIDE: u32 = 1732;
const ROUNDS: u32 = 12;

fn main() {
    report("one chart", &grid(SIDE));
    report("charts of 64 x 64 quads", &grid(64));
    report("charts of 16 x 16 quads", &grid(16));
    report("vertices in random order", &shuffled(grid(SIDE)));
}

/// A hilly grid of `SIDE` x `SIDE` quads with a 4 x 4 hole in every 64 x 64; vertices are split between charts.
fn grid(chart: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    for (x0, y0) in
        (0..SIDE).step_by(chart as usize).flat_map(|x| (0..SIDE).step_by(chart as usize).map(move |y| (x, y)))
    {
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

fn report(name: &str, mesh: &TriMesh) {
    let (found, seconds) = best(|| boundary(mesh));
    let (loops, loop_seconds) = best(|| loops(&found));
    let (parts, part_seconds) = best(|| components(mesh, &found));
    let millions = mesh.triangles.len() as f64 / 1e6;
    println!(
        "{name}: {millions:.2} M triangles, {:.2} M vertices, {} points, {} copies: {:.0} M triangles/s ({seconds:.3} s); \
         {} loops {loop_seconds:.4} s; {} components {part_seconds:.3} s",
        mesh.positions.len() as f64 / 1e6,
        found.points.len(),
        found.copies.len(),
        millions / seconds,
        loops.loops.len(),
        parts.list.len(),
    );
}

/// Seconds on the processor (Linux), so that other programs on the machine do not count; else seconds that passed.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let on_processor = std::fs::read_to_string("/proc/thread-self/schedstat");
    let nanoseconds = on_processor.ok().and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |n| n * 1e-9)
}

/// The fastest of some rounds.
fn best<T>(work: impl Fn() -> T) -> (T, f64) {
    let mut fastest = f64::INFINITY;
    let mut result = work();
    for _ in 0..ROUNDS {
        let start = seconds();
        result = work();
        fastest = fastest.min(seconds() - start);
    }
    (result, fastest)
}
