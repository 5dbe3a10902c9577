//! The report of a run: `report.json`, the page, the map data, the table on the terminal.

mod attention;
mod base64;
mod drawing;
mod geojson;
mod hillshade;
mod html;
mod kind;
mod map;
mod model;
mod numbers;
mod round;
mod summary;
mod table;

pub use attention::{Attention, attention};
pub use drawing::{CellDrawing, CellStatus, ClusterDrawing, Drawing, HoleDrawing};
pub use geojson::{cells_geojson, holes_geojson};
pub use hillshade::HeightRaster;
pub use html::{PageError, page};
pub use kind::{HoleClass, HoleKind, HoleShape};
pub use model::{
    ClusterRecord, DefectRecord, Execution, HoleRecord, Outcome, REPORT_VERSION, Report, SceneRecord,
    SeamRecord, StageRecord,
};
pub use summary::{ByKind, KindCount, Summary};
pub use table::table;
