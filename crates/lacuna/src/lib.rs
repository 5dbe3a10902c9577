//! Repairs the holes of tiled city and terrain meshes, from the tiles alone.
//!
//! The library behind the command line: configuration, the pipeline (scan, plan, close, fill, seams, write), report.

pub mod bench;
pub mod cli;
pub mod config;
mod exit;
mod geometry;
mod interrupt;
pub mod logging;
mod pipeline;
pub mod progress;
pub mod report;
mod verify;

pub use exit::ExitCode;
pub use geometry::PolygonSet;
pub use interrupt::Interrupt;
pub use pipeline::{RunError, RunResult, SceneInfo, info, inspect, repair};
pub use verify::{Again, PromiseResult, Status, Verdict, VerifyOptions, digest, verify};
