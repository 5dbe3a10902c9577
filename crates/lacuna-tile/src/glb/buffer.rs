//! Bytes behind the document's buffers.

use super::document::{Buffer, Document};
use super::{json_fault, uri};
use crate::fault::Fault;
use std::borrow::Cow;
use std::io::Read as _;
use std::path::Path;

/// Bytes of each buffer, in the document's order; empty for a buffer that has none (the placeholder of an extension).
pub(super) type Buffers<'a> = Vec<Cow<'a, [u8]>>;

/// Finds the bytes of every buffer: the BIN chunk, a `data:` URI, or a file in the tile's folder.
///
/// # Errors
/// A URI that could leave the folder; an unreadable file; fewer bytes than `byteLength` says.
pub(super) fn resolve<'a>(
    document: &Document,
    bin: Option<&'a [u8]>,
    folder: &Path,
) -> Result<Buffers<'a>, Fault> {
    let pointer = |at: usize| format!("/buffers/{at}");
    let resolve_one = |(at, buffer): (usize, &Buffer)| -> Result<Cow<'a, [u8]>, Fault> {
        let bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => {
                read_uri(uri, buffer.byte_length, folder).map_err(|p| json_fault(pointer(at), p))?
            }
            (None, Some(bin)) if at == 0 => Cow::Borrowed(bin),
            (None, _) => return Ok(Cow::Borrowed(&[])),
        };
        check_length(bytes, buffer.byte_length).map_err(|p| json_fault(pointer(at), p))
    };
    document.buffers.iter().enumerate().map(resolve_one).collect()
}

fn check_length(bytes: Cow<'_, [u8]>, declared: u64) -> Result<Cow<'_, [u8]>, String> {
    match usize::try_from(declared) {
        Ok(length) if length <= bytes.len() => Ok(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..length]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length);
                Cow::Owned(bytes)
            }
        }),
        _ => Err(format!("declares {declared} bytes, only {} are there", bytes.len())),
    }
}

fn read_uri(uri: &str, length: u64, folder: &Path) -> Result<Cow<'static, [u8]>, String> {
    if let Some(decoded) = uri::data_uri(uri) {
        return decoded.map(Cow::Owned);
    }
    let shown: String = uri.chars().take(60).flat_map(char::escape_debug).collect();
    let relative = uri::safe_relative(uri).map_err(|problem| format!("\"{shown}\": {problem}"))?;
    read_file(folder, &relative, length).map(Cow::Owned).map_err(|e| format!("\"{shown}\": {e}"))
}

/// At most `length` bytes of a regular file that has as many.
fn read_file(folder: &Path, relative: &str, length: u64) -> std::io::Result<Vec<u8>> {
    let file = uri::open_beneath(folder, relative)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    if metadata.len() < length {
        return Err(std::io::Error::other(format!("{} bytes, but {length} are declared", metadata.len())));
    }
    let mut bytes = Vec::new();
    let room = usize::try_from(length).map_err(|_| std::io::Error::from(std::io::ErrorKind::OutOfMemory))?;
    bytes.try_reserve_exact(room).map_err(|_| std::io::Error::from(std::io::ErrorKind::OutOfMemory))?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}
