//! Wavefront OBJ in the dialects that producers write.

mod read;
mod rows;
mod scanner;
mod size;
mod write;

pub(crate) use read::read;
pub(crate) use size::read_header;
pub(crate) use write::{append, new_tile};
