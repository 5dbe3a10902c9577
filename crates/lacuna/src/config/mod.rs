//! Settings of a run: the configuration file, the flags, and what they resolve to.

mod error;
mod file;
mod keys;
mod memory;
mod polygon;
mod resolve;
mod settings;
pub(crate) mod values;
mod water;

pub(crate) use file::{parse_ron, version_one};
pub(crate) use keys::{Key, key, nearest};

pub use error::{ConfigError, FileError};
pub use memory::{Machine, MemoryLimit};
pub use polygon::{Frame, PolygonFile};
pub use settings::{
    AreaLimit, AreaSettings, ClosedFiller, External, FailOn, FillSettings, FindSettings, HoleClassFilter,
    HoleShapeFilter, MethodName, OpenFiller, ProgressMode, Region, RegionPlace, RunSettings, SceneSettings,
    Selection, Settings, Untouched, UpAxis,
};
pub use values::AreaArgument;
pub use water::{WaterFile, WaterIslands, WaterMode, WaterPolygon};
