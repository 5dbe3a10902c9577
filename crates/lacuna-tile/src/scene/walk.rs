//! The folder walk: sorted, without surprises from links and special files.

use super::SceneOptions;
use super::error::SceneError;
use std::fs::{self, DirEntry};
use std::path::{Path, PathBuf};

/// Deepest nesting that is walked.
const MAX_DEPTH: usize = 64;

/// What a walk found.
#[derive(Debug, Default)]
pub(super) struct Walked {
    /// Regular files, relative to the root with forward slashes, sorted.
    pub(super) files: Vec<String>,
    /// What was left out.
    pub(super) warnings: Vec<String>,
}

/// Walks `root`; the result does not depend on the order in which the system lists a folder.
pub(super) fn walk(root: &Path, options: &SceneOptions) -> Result<Walked, SceneError> {
    let metadata = fs::metadata(root).map_err(|e| io(root, "open the scene", e))?;
    if !metadata.is_dir() {
        return Err(SceneError::NotAFolder { path: root.to_owned() });
    }
    let real_root = fs::canonicalize(root).map_err(|e| io(root, "open the scene", e))?;
    let mut walker = Walker { real_root: real_root.clone(), options, found: Walked::default() };
    walker.folder(root, "", &mut vec![real_root])?;
    walker.found.files.sort_unstable();
    Ok(walker.found)
}

struct Walker<'a> {
    real_root: PathBuf,
    options: &'a SceneOptions,
    found: Walked,
}

impl Walker<'_> {
    /// Walks one folder. `above` holds the real paths of the folders from the root down to this one.
    fn folder(&mut self, folder: &Path, relative: &str, above: &mut Vec<PathBuf>) -> Result<(), SceneError> {
        if above.len() > MAX_DEPTH {
            return Err(SceneError::TooDeep { path: folder.to_owned(), limit: MAX_DEPTH });
        }
        for entry in sorted_entries(folder)? {
            let path = entry.path();
            let name = entry.file_name();
            let name = name.to_str().ok_or_else(|| SceneError::NameNotUtf8 { path: path.clone() })?;
            let inner = if relative.is_empty() { name.to_owned() } else { format!("{relative}/{name}") };
            self.entry(&entry, &path, inner, above)?;
        }
        Ok(())
    }

    fn entry(
        &mut self,
        entry: &DirEntry,
        path: &Path,
        relative: String,
        above: &mut Vec<PathBuf>,
    ) -> Result<(), SceneError> {
        let kind = entry.file_type().map_err(|e| io(path, "read the kind of", e))?;
        let real = if kind.is_symlink() {
            match self.link_target(path, above) {
                Ok(real) => real,
                Err(reason) => {
                    self.warn(&relative, reason);
                    return Ok(());
                }
            }
        } else {
            above[above.len() - 1].join(entry.file_name())
        };
        let kind = fs::metadata(path).map_err(|e| io(path, "read the kind of", e))?.file_type();
        if kind.is_dir() && above.len() == 1 && relative == "lacuna" && path.join("manifest.json").exists() {
            self.warn(&relative, "records of an earlier run: left out");
        } else if kind.is_dir() {
            above.push(real);
            self.folder(path, &relative, above)?;
            above.pop();
        } else if kind.is_file() {
            self.found.files.push(relative);
        } else {
            self.warn(&relative, "not a regular file: left out");
        }
        Ok(())
    }

    /// The real path behind a link, or why it is not followed.
    fn link_target(&self, link: &Path, above: &[PathBuf]) -> Result<PathBuf, &'static str> {
        if !self.options.follow_symlinks {
            return Err("a symbolic link: not followed");
        }
        let real = fs::canonicalize(link).map_err(|_| "a symbolic link to nothing: left out")?;
        if !real.starts_with(&self.real_root) {
            return Err("a symbolic link that leaves the scene: not followed");
        }
        if above.contains(&real) {
            return Err("a symbolic link to a folder above it: not followed");
        }
        Ok(real)
    }

    fn warn(&mut self, relative: &str, reason: &str) {
        self.found.warnings.push(format!("{}: {reason}", relative.escape_debug()));
    }
}

fn sorted_entries(folder: &Path) -> Result<Vec<DirEntry>, SceneError> {
    let mut entries = fs::read_dir(folder)
        .and_then(Iterator::collect::<std::io::Result<Vec<_>>>)
        .map_err(|e| io(folder, "list the folder", e))?;
    entries.sort_by_key(DirEntry::file_name);
    Ok(entries)
}

fn io(path: &Path, operation: &'static str, source: std::io::Error) -> SceneError {
    SceneError::Io { path: path.to_owned(), operation, source }
}
