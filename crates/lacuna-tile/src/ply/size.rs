//! The size of a PLY tile, from its header alone.

use super::header::{Element, Header, parse_header};
use super::read::find_position;
use crate::error::TileError;
use crate::fault::Fault;
use crate::source::open_regular;
use crate::types::TileHeader;
use memchr::{memchr, memmem, memrchr};
use std::io::Read;
use std::path::Path;

const STEP_BYTES: u64 = 64 * 1024;
const LONGEST_HEADER_BYTES: usize = 64 * 1024 * 1024;

/// Reads the header and nothing else, and compares its counts with the size of the file. Triangles are the declared faces (a polygon counts once); strips count one
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
        if read == 0 || start.len() > LONGEST_HEADER_BYTES || holds_last_line(&start) {
            break;
        }
    }
    let size = parse_header(&start).and_then(|header| size(&header, metadata.len()));
    size.map_err(|fault| fault.at(path))
}

/// True if the line `end_header` is there with its end; comments may hold the word too.
fn holds_last_line(start: &[u8]) -> bool {
    memmem::find_iter(start, b"end_header").any(|at| {
        let line = memrchr(b'\n', &start[..at]).map_or(0, |end| end + 1);
        start[line..at].trim_ascii().is_empty() && memchr(b'\n', &start[at..]).is_some()
    })
}

fn size(header: &Header, bytes: u64) -> Result<TileHeader, Fault> {
    check_counts(header, bytes)?;
    let vertices = header.elements[find_position(header)?.element].count;
    let strips = header.find("tristrips").map_or(0, |_| bytes / 4);
    let faces = header.find("face").map(|index| &header.elements[index]);
    let triangles =
        faces.filter(|f| f.find_indices().is_some()).map_or(0, |f| f.count).saturating_add(strips);
    Ok(TileHeader { vertices, triangles, bytes })
}

/// A count that the file cannot hold is a fault of the file, and no reason to ask for that much memory.
fn check_counts(header: &Header, bytes: u64) -> Result<(), Fault> {
    let body = bytes.saturating_sub(header.body as u64);
    let left_after = |left: u64, element: &Element| element.left_after(header.encoding, left);
    header.elements.iter().try_fold(body, left_after).map(|_| ())
}
