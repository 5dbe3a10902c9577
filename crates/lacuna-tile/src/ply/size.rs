//! The size of a PLY tile, from its header alone.

use super::header::{Header, parse_header};
use crate::error::{Place, TileError};
use crate::source::open_regular;
use crate::types::TileHeader;
use memchr::memmem;
use std::io::Read;
use std::path::Path;

const STEP_BYTES: u64 = 64 * 1024;
const LONGEST_HEADER_BYTES: usize = 64 * 1024 * 1024;

/// Reads the header and nothing else. Triangles are the declared faces (a polygon counts once); strips count one
/// triangle for every four bytes of the file, which is more than they can hold.
///
/// # Errors
/// `Io`, `Malformed`, `Unsupported`.
pub(crate) fn read_header(path: &Path) -> Result<TileHeader, TileError> {
    let (mut file, metadata) = open_regular(path)?;
    let mut start = Vec::new();
    loop {
        let read = (&mut file).take(STEP_BYTES).read_to_end(&mut start);
        let read = read.map_err(|e| TileError::io(path, "read", e))?;
        if read == 0 || start.len() > LONGEST_HEADER_BYTES || memmem::find(&start, b"end_header").is_some() {
            break;
        }
    }
    start.push(b'\n'); // `end_header` may be the last thing that was read
    let header = parse_header(&start).map_err(|fault| fault.at(path))?;
    let vertices = count(&header, "vertex").ok_or_else(|| {
        let advice = "export the tile again or take it out of the scene";
        TileError::malformed(path, Place::File, "the header declares no element `vertex`", advice)
    })?;
    let strips = count(&header, "tristrips").map_or(0, |_| metadata.len() / 4);
    let triangles = count(&header, "face").unwrap_or(0).saturating_add(strips);
    Ok(TileHeader { vertices, triangles, bytes: metadata.len() })
}

fn count(header: &Header, element: &str) -> Option<u64> {
    header.find(element).map(|index| header.elements[index].count)
}
