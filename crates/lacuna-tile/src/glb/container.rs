//! The GLB container: a header, a JSON chunk, perhaps a BIN chunk, perhaps chunks of others.

use crate::error::Place;
use crate::fault::Fault;
use gltf::binary::{Error as BinaryError, Glb};
use std::borrow::Cow;
use std::io::{self, Write};

/// Bytes before the JSON text: the file's header and the chunk's own.
pub(super) const JSON_START: usize = 20;
const HEADER_BYTES: u32 = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The parts of a GLB file, as they lie in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunks<'a> {
    /// JSON text without its padding.
    pub(super) json: &'a [u8],
    /// BIN chunk with its padding.
    pub(super) bin: Option<&'a [u8]>,
    /// Whole chunks after BIN, which belong to others.
    pub(super) tail: &'a [u8],
}

/// Splits a file into its chunks (glTF 2.0 specification, section 4).
pub(super) fn split(file: &[u8]) -> Result<Chunks<'_>, Fault> {
    let length = declared_length(file)?;
    let file = &file[..length];
    let glb = Glb::from_slice(file).map_err(|e| container_fault(&e))?;
    let (Cow::Borrowed(json), bin) = (glb.json, glb.bin) else {
        return Err(Fault::malformed(Place::File, "the chunks could not be told apart"));
    };
    let bin = match bin {
        Some(Cow::Borrowed(bin)) => Some(bin),
        _ => None,
    };
    let bin_bytes = bin.map_or(0, |bin| CHUNK_HEADER_BYTES + bin.len());
    let tail = file.get(JSON_START + json.len() + bin_bytes..).unwrap_or(&[]);
    check_tail(tail, length - tail.len())?;
    Ok(Chunks { json: trim_padding(json), bin, tail })
}

/// The length that the header declares, checked: the container reader trusts it to be at least a header's.
fn declared_length(file: &[u8]) -> Result<usize, Fault> {
    let Some(header) = file.get(..JSON_START) else {
        return Err(Fault::malformed(Place::File, format!("{} bytes are no GLB file", file.len())));
    };
    check_header(header)?;
    let length = u32_at(header, 8);
    match usize::try_from(length) {
        Ok(length) if length >= JSON_START && length <= file.len() => Ok(length),
        _ => {
            let problem = format!("the header declares {length} bytes, the file has {}", file.len());
            Err(Fault::malformed(Place::Byte(8), problem))
        }
    }
}

/// Magic and version of the first bytes of a file.
pub(super) fn check_header(header: &[u8]) -> Result<(), Fault> {
    if header.get(..4) != Some(b"glTF") {
        return Err(Fault::malformed(Place::Byte(0), "the file does not begin with glTF"));
    }
    match u32_at(header, 4) {
        2 => Ok(()),
        1 => Err(Fault::unsupported(Place::Byte(4), "glTF 1.0", "convert it: npx 3d-tiles-tools upgrade")),
        other => Err(Fault::unsupported(
            Place::Byte(4),
            format!("glTF version {other}"),
            "export the tile as glTF 2.0",
        )),
    }
}

/// The little-endian number at a byte; 0 past the end.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes)
}

/// JSON is padded with spaces; some writers pad with NUL.
pub(super) fn trim_padding(json: &[u8]) -> &[u8] {
    let end = json.iter().rposition(|&b| b != b' ' && b != 0).map_or(0, |last| last + 1);
    &json[..end]
}

/// The tail must be whole chunks, none of them a second JSON or BIN: it is written back behind a longer BIN chunk.
fn check_tail(mut tail: &[u8], mut at: usize) -> Result<(), Fault> {
    while !tail.is_empty() {
        let length = u32_at(tail, 0) as usize;
        let kind = tail.get(4..8);
        if kind == Some(b"JSON") || kind == Some(b"BIN\0") {
            return Err(Fault::malformed(Place::Byte(at as u64), "a second JSON or BIN chunk"));
        }
        let Some(rest) = CHUNK_HEADER_BYTES.checked_add(length).and_then(|end| tail.get(end..)) else {
            return Err(Fault::malformed(Place::Byte(at as u64), "a chunk runs past the end of the file"));
        };
        at += tail.len() - rest.len();
        tail = rest;
    }
    Ok(())
}

fn container_fault(error: &gltf::Error) -> Fault {
    match error {
        gltf::Error::Binary(BinaryError::ChunkLength { length, length_read, .. }) => Fault::malformed(
            Place::File,
            format!("a chunk declares {length} bytes, only {length_read} are left"),
        ),
        gltf::Error::Binary(BinaryError::ChunkType(_)) => {
            Fault::malformed(Place::File, "the chunks are not JSON first, then BIN")
        }
        gltf::Error::Binary(BinaryError::UnknownChunkType(kind)) => Fault::malformed(
            Place::File,
            format!("a chunk of type \"{}\" where JSON or BIN belongs", kind.escape_ascii()),
        ),
        other => Fault::malformed(Place::File, other.to_string()),
    }
}

/// Writes a GLB file: JSON padded with spaces, BIN with zeros, both to multiples of four; then the tail as it is.
pub(super) fn write(target: &mut impl Write, json: &[u8], bin: &[&[u8]], tail: &[u8]) -> io::Result<()> {
    let bin_bytes: usize = bin.iter().map(|part| part.len()).sum();
    let has_bin = bin_bytes > 0;
    let total = file_bytes(json.len(), bin_bytes, tail.len());
    target.write_all(b"glTF")?;
    target.write_all(&2_u32.to_le_bytes())?;
    target.write_all(&length_field(total)?)?;
    target.write_all(&length_field(padded(json.len()))?)?;
    target.write_all(b"JSON")?;
    target.write_all(json)?;
    target.write_all(&b"   "[..padded(json.len()) - json.len()])?;
    if has_bin {
        target.write_all(&length_field(padded(bin_bytes))?)?;
        target.write_all(b"BIN\0")?;
        for part in bin {
            target.write_all(part)?;
        }
        target.write_all(&[0; 3][..padded(bin_bytes) - bin_bytes])?;
    }
    target.write_all(tail)
}

/// Size of the file that `write` makes.
pub(super) fn file_bytes(json: usize, bin: usize, tail: usize) -> usize {
    let bin_chunk = if bin > 0 { CHUNK_HEADER_BYTES + padded(bin) } else { 0 };
    HEADER_BYTES as usize + CHUNK_HEADER_BYTES + padded(json) + bin_chunk + tail
}

/// The next multiple of four.
pub(super) fn padded(bytes: usize) -> usize {
    bytes.next_multiple_of(4)
}

fn length_field(bytes: usize) -> io::Result<[u8; 4]> {
    let length = u32::try_from(bytes).map_err(|_| io::Error::from(io::ErrorKind::FileTooLarge))?;
    Ok(length.to_le_bytes())
}
