//! What is wrong with a configuration or a command line. All of it ends with exit code 2.

use std::fmt;
use std::path::PathBuf;

/// A configuration that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A place in the configuration file.
    #[error(transparent)]
    File(Box<FileError>),
    /// A polygon file.
    #[error("{}: {what}", path.display())]
    Polygon {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A list of tiles.
    #[error("{}: {what}", path.display())]
    Cells {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// Something that a later version may do.
    #[error("{what} is not in this version{}", help.as_ref().map(|h| format!("; {h}")).unwrap_or_default())]
    NotInThisVersion {
        /// Flag, verb or value.
        what: String,
        /// What to use instead.
        help: Option<String>,
    },
    /// Settings that are missing, or do not go together.
    #[error("{0}")]
    Settings(String),
}

/// An error at a place of the configuration file, with the line and a caret under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// Characters that are wrong, at least 1.
    pub width: usize,
    /// The text of the line.
    pub source_line: String,
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub help: Option<String>,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.line.to_string();
        let gutter = " ".repeat(number.len());
        writeln!(f, "{}:{}:{}: {}", self.path.display(), self.line, self.column, self.what)?;
        writeln!(f, " {gutter} |")?;
        writeln!(f, " {number} | {}", printable(&self.source_line))?;
        let indent = " ".repeat(self.column.saturating_sub(1));
        write!(f, " {gutter} | {indent}{}", "^".repeat(self.width.max(1)))?;
        self.help.as_ref().map_or(Ok(()), |help| write!(f, "\n {gutter} = {help}"))
    }
}

/// A line in which each character takes one column, whatever it holds.
fn printable(line: &str) -> String {
    line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

impl std::error::Error for FileError {}

impl From<FileError> for ConfigError {
    fn from(error: FileError) -> Self {
        Self::File(Box::new(error))
    }
}
