//! The verb `bench`: time, memory and success of the methods over made scenes, next to a plain copy of the same files.
//!
//! [`config`] says which scenes and methods; [`scene_store`] makes each scene once, tile by tile; [`rounds`] runs the
//! methods in turn, each run in a process of its own that [`measure`] watches; [`result`] takes medians; [`table`] and
//! [`pictures`] show them; [`guard`] compares them with an earlier run.

mod chart;
mod config;
mod guard;
mod measure;
mod pictures;
mod result;
mod rounds;
mod scene_store;
mod table;
mod verb;

pub use config::{BenchConfig, SceneSpec, Series};
pub use guard::worsened;
pub use result::{BenchResult, Distribution, HoleCount, MachineFacts, Row, RowOutcome, Sample};
pub use scene_store::MadeScene;
pub use table::markdown;
pub use verb::{BenchOptions, BenchOutcome, bench};
