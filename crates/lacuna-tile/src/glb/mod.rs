//! Binary glTF 2.0: geometry in, patches appended as primitives of their own.
//!
//! Frame: node transforms in f64, then the file's up axis turned to z up, then `CESIUM_RTC` added. Textures, materials and
//! every part of the file that is no triangle geometry pass through unread.

mod accessor;
mod append;
mod buffer;
mod container;
mod document;
mod draft;
mod edit;
mod frame;
mod header;
mod model;
mod new_tile;
mod nodes;
mod patch;
mod topology;
mod uri;

pub(crate) use append::append;
pub(crate) use header::read_header;
pub(crate) use model::read;
pub(crate) use new_tile::new_tile;

use crate::error::Place;
use crate::fault::Fault;
use std::fmt::Display;

/// A fault at a JSON pointer.
fn json_fault(pointer: impl Display, problem: impl Into<String>) -> Fault {
    Fault::malformed(Place::Json(pointer.to_string()), problem)
}

/// The element of a JSON array that an index in the file names.
fn element<'a, T>(array: &'a [T], index: u64, name: &str, from: &str) -> Result<&'a T, Fault> {
    usize::try_from(index)
        .ok()
        .and_then(|i| array.get(i))
        .ok_or_else(|| json_fault(from, format!("names {name} {index}, but there are {}", array.len())))
}
