//! The report of a run: `report.json`, the page, the map data, the table on the terminal.

mod drawing;
mod hillshade;
mod kind;
mod model;
mod round;
mod summary;

pub use drawing::{CellDrawing, CellStatus, ClusterDrawing, Drawing, HoleDrawing};
pub use hillshade::HeightRaster;
pub use kind::{HoleClass, HoleKind, HoleShape};
pub use model::{
    ClusterRecord, DefectRecord, Execution, HoleRecord, Outcome, REPORT_VERSION, Report, SceneRecord, SeamRecord,
    StageRecord,
};
pub use summary::{ByKind, KindCount, Summary};
