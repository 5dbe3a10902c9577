//! Prints time and triangle quality of fills of a wavy hole with 1e3, 1e4 and 1e5 contour vertices.
//!
//! `cargo run --release -p lacuna-fill --example fill_speed [largest number of vertices]`

use glam::{DVec2, DVec3};
use lacuna_fill::{FillParams, HeightRule, fill};
use lacuna_mesh::{Contour, ContourEdge, ContourRing, ContourVertex, EdgeKind};
use lacuna_solve::FaerSolver;
use std::time::Instant;

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

#[allow(clippy::print_stdout)] // an example is a command line
fn main() {
    let largest = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(100_000);
    println!(
        "{:>9} {:>20} {:>9} {:>10} {:>8} {:>6} {:>7} {:>6}",
        "contour", "density", "new", "triangles", "seconds", "mean q", "q > 0.5", "min q"
    );
    for vertices in [1_000, 10_000, 100_000].into_iter().filter(|&n| n <= largest) {
        let contour = lake(vertices);
        let sparse = FillParams::default();
        let radius = 0.1 * vertices as f64 / 8.0;
        let even = FillParams { growth: 0.0, spacing_m: Some((radius / 300.0).max(0.1)), ..sparse };
        let rim = FillParams { growth: 0.0, ..sparse };
        for (name, params) in [
            ("graded 0.3", sparse),
            ("even", even),
            ("even, harmonic", FillParams { heights: HeightRule::Harmonic, ..even }),
            ("as the rim", rim),
        ] {
            if vertices > 1_000 && name == "as the rim" || vertices > 10_000 && name == "even" {
                continue;
            }
            let start = Instant::now();
            match fill(&contour, &params, &FaerSolver) {
                Ok(done) => println!(
                    "{vertices:>9} {name:>20} {:>9} {:>10} {:>8.3} {:>6.3} {:>7.4} {:>6.3}",
                    done.patch.vertices.len(),
                    done.patch.triangles.len(),
                    start.elapsed().as_secs_f64(),
                    done.quality.mean,
                    done.quality.share_good,
                    done.quality.min
                ),
                Err(e) => println!("{vertices:>9} {name:>20} {e}"),
            }
        }
    }
}
