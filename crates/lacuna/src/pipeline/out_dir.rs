//! The output folder: may it be written, who holds it, what an earlier run left.

use super::RunError;
use super::manifest::{MANIFEST, Manifest};
use crate::ExitCode;
use lacuna_tile::is_temporary;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// The folder inside OUT that is lacuna's own.
pub(crate) const OWN_FOLDER: &str = "lacuna";

/// An output folder that this run holds; the lock goes with the value.
pub(crate) struct OutDir {
    pub(crate) root: PathBuf,
    pub(crate) own: PathBuf,
    /// What an earlier run left.
    pub(crate) earlier: Option<Manifest>,
    _lock: File,
}

/// Takes the output folder.
///
/// Steps: refuse OUT = SCENE, OUT inside SCENE and SCENE inside OUT (by device and inode of every ancestor); make it; lock
/// it; refuse files without a manifest.
pub(crate) fn take(scene: &Path, out: &Path) -> Result<OutDir, RunError> {
    refuse_nesting(scene, out)?;
    let own = out.join(OWN_FOLDER);
    let stranger = !own.join(MANIFEST).exists() && holds_files(out);
    if stranger {
        return Err(RunError::usage(format!(
            "{} holds files that no run of lacuna left (no {OWN_FOLDER}/{MANIFEST}); give an empty or new folder",
            out.display()
        )));
    }
    fs::create_dir_all(&own).map_err(|e| io_error("make", &own, &e))?;
    let lock = lock(&own.join(".lock"), out)?;
    remove_temporaries(out)?;
    let earlier = Manifest::read(&own.join(MANIFEST))?;
    Ok(OutDir { root: out.to_owned(), own, earlier, _lock: lock })
}

/// Unfinished files of a run that was killed.
fn remove_temporaries(folder: &Path) -> Result<(), RunError> {
    let entries = fs::read_dir(folder).map_err(|e| io_error("read", folder, &e))?;
    for entry in entries.flatten() {
        let path = entry.path();
        let kind = entry.file_type().map_err(|e| io_error("read", &path, &e))?;
        if kind.is_dir() {
            remove_temporaries(&path)?;
        } else if kind.is_file() && is_temporary(&entry.file_name()) {
            fs::remove_file(&path).map_err(|e| io_error("delete", &path, &e))?;
        }
    }
    Ok(())
}

/// An error of an operation on a path.
pub(crate) fn io_error(operation: &str, path: &Path, error: &std::io::Error) -> RunError {
    RunError::input_output(format!(
        "cannot {operation} {}: {error}; check the path, its permissions and the free space",
        path.display()
    ))
}

/// True if the folder holds anything but an empty own folder of an earlier try.
fn holds_files(out: &Path) -> bool {
    let Ok(entries) = fs::read_dir(out) else { return false };
    entries.flatten().any(|e| {
        let own = e.file_name() == OWN_FOLDER;
        let only_lock =
            || fs::read_dir(e.path()).is_ok_and(|inner| inner.flatten().all(|f| f.file_name() == ".lock"));
        !(own && only_lock())
    })
}

pub(crate) fn refuse_nesting(scene: &Path, out: &Path) -> Result<(), RunError> {
    fs::metadata(scene).map_err(|e| io_error("open the scene", scene, &e))?;
    let scene_chain = ancestors(scene);
    let out_chain = ancestors(out);
    let (Some(scene_self), out_self) = (scene_chain.first(), identity(out)) else {
        return Err(RunError::input_output(format!("cannot read {}; check the path", scene.display())));
    };
    let problem = if out_self.as_ref() == Some(scene_self) {
        "is the scene itself"
    } else if out_chain.contains(scene_self) {
        "lies inside the scene"
    } else if out_self.is_some_and(|o| scene_chain.contains(&o)) {
        "holds the scene"
    } else {
        return Ok(());
    };
    Err(RunError::usage(format!(
        "the folder {} {problem}; give a folder beside it, inputs are never written",
        out.display()
    )))
}

/// What tells one folder from another, whatever its path.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|m| (m.dev(), m.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    fs::canonicalize(path).ok()
}

/// Identities of the existing folders from a path upward.
#[cfg(unix)]
fn ancestors(path: &Path) -> Vec<(u64, u64)> {
    existing(path).as_deref().map_or_else(Vec::new, |p| p.ancestors().filter_map(identity).collect())
}

#[cfg(not(unix))]
fn ancestors(path: &Path) -> Vec<PathBuf> {
    existing(path).as_deref().map_or_else(Vec::new, |p| p.ancestors().filter_map(identity).collect())
}

/// The nearest existing folder at or above a path, without links.
fn existing(path: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(path).ok()?;
    absolute.ancestors().find_map(|p| fs::canonicalize(p).ok())
}

/// A kernel lock: it goes when the process ends, however it ends.
fn lock(path: &Path, out: &Path) -> Result<File, RunError> {
    let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    let mut file = open.map_err(|e| io_error("open", path, &e))?;
    match file.try_lock() {
        Ok(()) => {
            // Text for the message of a second run only; the kernel's lock is what counts.
            let _ = file.set_len(0);
            let _ = write!(file, "process {}", std::process::id());
            Ok(file)
        }
        Err(TryLockError::WouldBlock) => {
            let mut holder = String::new();
            let _ = file.read_to_string(&mut holder);
            Err(RunError {
                exit: ExitCode::Busy,
                message: format!(
                    "another run ({}) holds {}; wait for it or stop it",
                    holder.escape_debug(),
                    out.display()
                ),
            })
        }
        Err(TryLockError::Error(e)) => Err(io_error("lock", path, &e)),
    }
}
