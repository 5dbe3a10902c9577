//! Files that appear whole or not at all, and stay after a power loss.

use crate::error::TileError;
use crate::source::open_regular;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, TempPath};

/// Beginning of the names of unfinished files: what a killed run leaves behind starts with it.
pub const TEMPORARY_PREFIX: &str = ".lacuna-";
/// End of the names of unfinished files.
pub const TEMPORARY_SUFFIX: &str = ".tmp";
const BUFFER_BYTES: usize = 256 * 1024;

/// True if a file of this name is an unfinished one of a run that was killed.
#[must_use]
pub fn is_temporary(name: &OsStr) -> bool {
    name.to_str().is_some_and(|n| n.starts_with(TEMPORARY_PREFIX) && n.ends_with(TEMPORARY_SUFFIX))
}

/// What a commit made durable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Committed {
    /// Bytes written.
    pub bytes: u64,
    /// blake3 of what was written.
    pub hash: [u8; 32],
}

/// A file under a temporary name in its final folder. Dropped without `commit`, it is removed.
#[derive(Debug)]
pub struct AtomicFile {
    writer: BufWriter<File>,
    temporary: TempPath,
    target: PathBuf,
    hasher: blake3::Hasher,
    bytes: u64,
}

impl AtomicFile {
    /// Starts the file that is to appear at `target`: exclusively created, in the same folder, with the permissions of
    /// an ordinary new file.
    ///
    /// # Errors
    /// `Io`.
    pub fn create(target: &Path) -> Result<Self, TileError> {
        let (file, temporary) = new_temporary(target)?;
        Ok(Self {
            writer: BufWriter::with_capacity(BUFFER_BYTES, file),
            temporary,
            target: target.to_owned(),
            hasher: blake3::Hasher::new(),
            bytes: 0,
        })
    }

    /// Makes the content durable, gives it its final name (an existing file is replaced whole), makes the name durable.
    ///
    /// # Errors
    /// `Io`; the target is then as it was before, unless the folder alone could not be synchronised.
    pub fn commit(self) -> Result<Committed, TileError> {
        let Self { writer, temporary, target, hasher, bytes } = self;
        let file = writer.into_inner().map_err(|e| TileError::io(&target, "write", e.into_error()))?;
        finish(&file, temporary, &target)?;
        Ok(Committed { bytes, hash: *hasher.finalize().as_bytes() })
    }
}

impl Write for AtomicFile {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let written = self.writer.write(buffer)?;
        let (taken, _) = buffer.split_at(written);
        self.hasher.update(taken);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// How `copy_file` may copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CopyMode {
    /// Bytes are copied (by the kernel where it can).
    Copy,
    /// The copy shares its blocks with the original where the file system can; else as `Copy`.
    Reflink,
}

/// Whether `copy_file` shall hash what it copies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hashing {
    /// blake3 of the copied bytes.
    Yes,
    /// No hash.
    No,
}

/// What was copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Copied {
    /// Bytes copied.
    pub bytes: u64,
    /// blake3 of the bytes, if asked for.
    pub hash: Option<[u8; 32]>,
}

/// Copies a regular file's content; the copy appears whole or not at all. Permissions and times are those of a new file.
///
/// # Errors
/// `Io`, with the path that refused: that of `from` if it can't be read, else that of the copy; `Unsupported` if `from` is
/// no regular file.
pub fn copy_file(from: &Path, to: &Path, mode: CopyMode, hashing: Hashing) -> Result<Copied, TileError> {
    let (mut source, _) = open_regular(from)?;
    let (mut copy, temporary) = new_temporary(to)?;
    let shared = mode == CopyMode::Reflink && reflink(&source, &copy);
    let failed = |e| TileError::io(to, "copy into", e);
    let copied = match (shared, hashing) {
        (true, Hashing::Yes) => {
            copy.rewind().map_err(failed)?;
            copy_hashed((&mut copy, to), (&mut io::sink(), to))?
        }
        (true, Hashing::No) => Copied { bytes: copy.metadata().map_err(failed)?.len(), hash: None },
        (false, Hashing::Yes) => copy_hashed((&mut source, from), (&mut copy, to))?,
        (false, Hashing::No) => Copied { hash: None, ..copy_hashed((&mut source, from), (&mut copy, to))? },
    };
    finish(&copy, temporary, to)?;
    Ok(copied)
}

/// Makes the names in a folder durable (a no-op on systems whose folders can't be synchronised).
///
/// # Errors
/// `Io`.
pub fn sync_directory(directory: &Path) -> Result<(), TileError> {
    if cfg!(unix) {
        let failed = |e| TileError::io(directory, "synchronise the folder", e);
        File::open(directory).map_err(failed)?.sync_all().map_err(failed)?;
    }
    Ok(())
}

/// An open file and its temporary name, which removes the file when dropped. They are apart because tempfile's own writer
/// wraps the system's errors with that random name, and loses their errno.
fn new_temporary(target: &Path) -> Result<(File, TempPath), TileError> {
    let mut builder = Builder::new();
    builder.prefix(TEMPORARY_PREFIX).suffix(TEMPORARY_SUFFIX);
    let open = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
    let made = builder.make_in(directory_of(target), open);
    Ok(made.map_err(|e| TileError::io(target, "create a temporary file for", e))?.into_parts())
}

/// Sync, rename, sync of the folder. A failed sync is final: the temporary file is dropped, never tried again.
fn finish(file: &File, temporary: TempPath, target: &Path) -> Result<(), TileError> {
    file.sync_all().map_err(|e| TileError::io(target, "synchronise", e))?;
    temporary.persist(target).map_err(|e| TileError::io(target, "rename the temporary file to", e.error))?;
    sync_directory(directory_of(target))
}

fn directory_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(target_os = "linux")]
fn reflink(source: &File, target: &File) -> bool {
    rustix::fs::ioctl_ficlone(target, source).is_ok()
}

#[cfg(not(target_os = "linux"))]
fn reflink(_source: &File, _target: &File) -> bool {
    false
}

fn copy_hashed(
    (source, from): (&mut File, &Path),
    (target, to): (&mut impl Write, &Path),
) -> Result<Copied, TileError> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; BUFFER_BYTES];
    let mut bytes = 0;
    loop {
        let taken = match source.read(&mut buffer) {
            Ok(0) => return Ok(Copied { bytes, hash: Some(*hasher.finalize().as_bytes()) }),
            Ok(taken) => taken,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) => return Err(TileError::io(from, "read", e)),
        };
        let (chunk, _) = buffer.split_at(taken);
        hasher.update(chunk);
        target.write_all(chunk).map_err(|e| TileError::io(to, "copy into", e))?;
        bytes += taken as u64;
    }
}
