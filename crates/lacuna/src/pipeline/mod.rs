//! The main job, stage by stage: scan, plan, close, fill, seams, write, report.

mod area;
mod assemble;
mod baseline;
mod context;
mod error;
mod field;
mod frames;
mod hollow;
mod info;
mod kept;
mod manifest;
mod memory_account;
mod names;
mod out_dir;
mod outlines;
mod outputs;
mod preview;
mod run;
mod scan;
mod select;
mod solve;
mod stubs;
mod water_places;
mod watertight;
mod write;

pub use error::RunError;
pub use info::{SceneInfo, info};
pub use run::{RunResult, inspect, repair};
