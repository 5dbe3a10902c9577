//! One read of an input file into one buffer, hashed; only that buffer is used afterwards.

use crate::error::{Place, TileError};
use crate::types::ReadOptions;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::Path;

/// A file in memory.
#[derive(Debug)]
pub(crate) struct Source {
    /// All bytes.
    pub(crate) bytes: Vec<u8>,
    /// blake3 of `bytes`; zeros if the options leave it out.
    pub(crate) hash: [u8; 32],
}

/// Reads a whole file: opened read-only and without waiting (a FIFO must not hang), checked to be a regular file within
/// `options.max_bytes`, read once, and checked not to have changed meanwhile.
///
/// # Errors
/// `Io`, `Unsupported` (no regular file), `TooLarge`, `InputChanged`.
pub(crate) fn load(path: &Path, options: &ReadOptions) -> Result<Source, TileError> {
    let (mut file, before) = open_regular(path)?;
    check_size(path, before.len(), options)?;
    let bytes = read_all(&mut file, before.len()).map_err(|e| TileError::io(path, "read", e))?;
    let after = file.metadata().map_err(|e| TileError::io(path, "read the size of", e))?;
    check_unchanged(path, &before, &after, bytes.len() as u64)?;
    let hash = if options.skip_hash { [0; 32] } else { *blake3::hash(&bytes).as_bytes() };
    Ok(Source { bytes, hash })
}

/// As `load`, and the hash must be `expected` if one is given.
///
/// # Errors
/// As `load`; `InputChanged` if the hash differs.
pub(crate) fn load_expected(
    path: &Path,
    options: &ReadOptions,
    expected: Option<[u8; 32]>,
) -> Result<Source, TileError> {
    let source = load(path, &ReadOptions { skip_hash: expected.is_none(), ..options.clone() })?;
    match expected {
        Some(hash) if hash != source.hash => Err(TileError::InputChanged {
            path: path.to_owned(),
            problem: "its content is not what was scanned".to_owned(),
        }),
        _ => Ok(source),
    }
}

/// Opens a regular file for reading, without waiting.
///
/// # Errors
/// `Io`; `Unsupported` for folders, pipes, devices.
pub(crate) fn open_regular(path: &Path) -> Result<(File, Metadata), TileError> {
    let mut open = OpenOptions::new();
    open.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        open.custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed());
    }
    let file = open.open(path).map_err(|e| TileError::io(path, "open", e))?;
    let metadata = file.metadata().map_err(|e| TileError::io(path, "read the size of", e))?;
    if metadata.is_file() {
        return Ok((file, metadata));
    }
    let kind = if metadata.is_dir() { "a folder" } else { "not a regular file" };
    Err(TileError::unsupported(path, Place::File, format!("this is {kind}"), "give regular files as tiles"))
}

fn check_size(path: &Path, bytes: u64, options: &ReadOptions) -> Result<(), TileError> {
    match options.max_bytes {
        Some(limit_bytes) if bytes > limit_bytes => {
            Err(TileError::TooLarge { path: path.to_owned(), bytes, limit_bytes })
        }
        _ => Ok(()),
    }
}

/// Reads at most `length + 1` bytes, so that a growing file is noticed and can't fill the memory.
fn read_all(file: &mut File, length: u64) -> io::Result<Vec<u8>> {
    let room = usize::try_from(length).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(room.saturating_add(1))
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    file.take(length.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn check_unchanged(path: &Path, before: &Metadata, after: &Metadata, read: u64) -> Result<(), TileError> {
    let same_time = before.modified().ok() == after.modified().ok();
    if before.len() == read && after.len() == read && same_time {
        return Ok(());
    }
    let problem = format!("{} bytes before, {read} read, {} after", before.len(), after.len());
    Err(TileError::InputChanged { path: path.to_owned(), problem })
}
