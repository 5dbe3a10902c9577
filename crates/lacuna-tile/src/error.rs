//! What can go wrong with a tile: the file, the place in it, what is wrong, what to do.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Where in a file something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A byte offset from the file's start.
    Byte(u64),
    /// A line of a text file, from 1.
    Line(u64),
    /// A row of a named element, from 0 (PLY: `vertex`, `face`).
    Row {
        /// The element's name as the file has it.
        element: String,
        /// Row within the element, from 0.
        row: u64,
    },
    /// A JSON pointer (GLB: `/meshes/0/primitives/1`).
    Json(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => f.write_str("the file as a whole"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Row { element, row } => write!(f, "{} row {row}", element.escape_debug()),
            Self::Json(pointer) => write!(f, "JSON {}", pointer.escape_debug()),
        }
    }
}

/// A tile (or side file) that can't be read or written. Every message names the file, the place, what is wrong and what
/// to do about it.
#[derive(Debug, thiserror::Error)]
pub enum TileError {
    /// The operating system refused: unreadable, disk full, no permission.
    #[error("{}: cannot {operation}: {source}; check the path, its permissions and the free space", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried: "open", "read", "write", "sync" ...
        operation: &'static str,
        /// The system's answer, with its errno.
        source: io::Error,
    },
    /// The file breaks its own format.
    #[error("{}: {place}: {problem}; {advice}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong.
        problem: String,
        /// What to do.
        advice: String,
    },
    /// The file may be right, but this version can't read or extend it.
    #[error("{}: {place}: not supported: {problem}; {advice}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is not supported.
        problem: String,
        /// What to do.
        advice: String,
    },
    /// The input is not the file that was scanned, or it changed while it was read.
    #[error("{}: the file changed: {problem}; keep the scene still during a run and start the run again", path.display())]
    InputChanged {
        /// The file.
        path: PathBuf,
        /// What differs.
        problem: String,
    },
    /// The file is larger than the caller's limit.
    #[error("{}: {bytes} bytes are more than the limit of {limit_bytes} bytes; raise the limit or cut the tile", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Size of the file.
        bytes: u64,
        /// `ReadOptions::max_bytes`.
        limit_bytes: u64,
    },
    /// The file's own index or count type can't hold the numbers after the repair (decisions: such a tile fails).
    #[error(
        "{}: {place}: type `{index_type}` holds numbers up to {largest}, the repaired tile needs {needed}; \
         convert the tile to a wider index type",
        path.display()
    )]
    IndexTypeTooSmall {
        /// The file.
        path: PathBuf,
        /// Where the type is declared.
        place: Place,
        /// The type's name as the file has it.
        index_type: String,
        /// Largest number the type holds.
        largest: u64,
        /// Largest number that would have to be written.
        needed: u64,
    },
    /// A patch that does not fit the tile: a corner that does not exist, a position that is not finite.
    #[error("{}: patch of hole {}: {problem}; this is a fault of the program, please report it", path.display(), hole.escape_debug())]
    BadPatch {
        /// The tile the patch was meant for.
        path: PathBuf,
        /// The hole's id.
        hole: String,
        /// What does not fit.
        problem: String,
    },
}

impl TileError {
    /// An error of the operating system at `path`.
    pub(crate) fn io(path: &Path, operation: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), operation, source }
    }

    /// A file that breaks its own format.
    pub(crate) fn malformed(
        path: &Path,
        place: Place,
        problem: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        Self::Malformed { path: path.to_owned(), place, problem: problem.into(), advice: advice.into() }
    }

    /// A file that this version can't handle.
    pub(crate) fn unsupported(
        path: &Path,
        place: Place,
        problem: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        Self::Unsupported { path: path.to_owned(), place, problem: problem.into(), advice: advice.into() }
    }

    /// The message with the file's path as it lies below `root`: what a report may say, which must not depend on the
    /// place of the scene.
    #[must_use]
    pub fn message_below(&self, root: &Path) -> String {
        let message = self.to_string();
        let rest = message.strip_prefix(&self.path().display().to_string());
        match (self.path().strip_prefix(root), rest) {
            (Ok(relative), Some(rest)) => format!("{}{rest}", relative.display()),
            _ => message,
        }
    }

    /// The file the error is about.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Io { path, .. }
            | Self::Malformed { path, .. }
            | Self::Unsupported { path, .. }
            | Self::InputChanged { path, .. }
            | Self::TooLarge { path, .. }
            | Self::IndexTypeTooSmall { path, .. }
            | Self::BadPatch { path, .. } => path,
        }
    }

    /// The system's error number, if the operating system refused.
    #[must_use]
    pub fn errno(&self) -> Option<i32> {
        match self {
            Self::Io { source, .. } => source.raw_os_error(),
            _ => None,
        }
    }
}
