//! Stanford PLY: ascii and binary, in the dialects that producers write.

mod cursor;
mod header;
mod read;
mod rim;
mod rows;
mod scalar;
mod size;
mod write;

pub(crate) use read::read;
pub(crate) use size::read_header;
pub(crate) use write::{append, new_tile};
