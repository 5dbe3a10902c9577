//! Every file of SCENE and OUT with its hash; promise 1, and promise 2 for files that nothing was appended to.

use super::records::{ListedFile, OWN_FOLDER, Records};
use super::verdict::Findings;
use super::work::Work;
use crate::{ExitCode, RunError};
use lacuna_tile::is_temporary;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;

/// Size and hash of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FileFacts {
    pub(super) bytes: u64,
    pub(super) blake3: String,
}

/// All files of both folders, by relative path; those of OUT/lacuna are left out.
#[derive(Debug)]
pub(super) struct Files {
    pub(super) scene: BTreeMap<String, FileFacts>,
    pub(super) out: BTreeMap<String, FileFacts>,
}

impl Files {
    /// Hashes the files of a scene (tiles and side files as its reader lists them) and of OUT.
    pub(super) fn read(scene: &lacuna_tile::Scene, out: &Path, work: &Work<'_>) -> Result<Self, RunError> {
        let tiles = scene.tiles.iter().map(|tile| tile.relative.clone());
        let listed: BTreeSet<String> = tiles.chain(scene.side_files.iter().cloned()).collect();
        Ok(Self {
            scene: hash_all(&scene.root, listed.into_iter().collect(), work)?,
            out: hash_all(out, list_files(out, Some(OWN_FOLDER))?, work)?,
        })
    }

    /// True if OUT holds other bytes than SCENE under this name, or a file that SCENE lacks.
    pub(super) fn is_changed(&self, relative: &str) -> bool {
        self.out.get(relative).is_some_and(|now| self.scene.get(relative) != Some(now))
    }
}

/// Relative paths of all regular files under a folder, sorted, with forward slashes; one folder at the top can be left out.
pub(super) fn list_files(root: &Path, without: Option<&str>) -> Result<Vec<String>, RunError> {
    let mut found = Vec::new();
    list_into(root, "", without, &mut found)?;
    found.sort_unstable();
    Ok(found)
}

fn list_into(
    folder: &Path,
    prefix: &str,
    without: Option<&str>,
    found: &mut Vec<String>,
) -> Result<(), RunError> {
    let unreadable = |e: std::io::Error| RunError {
        exit: ExitCode::InputOutput,
        message: format!("cannot list {}: {e}; check the path and its permissions", folder.display()),
    };
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let kind = entry.file_type().map_err(unreadable)?;
        if kind.is_dir() && !(prefix.is_empty() && Some(name.as_str()) == without) {
            list_into(&entry.path(), &format!("{prefix}{name}/"), without, found)?;
        } else if kind.is_file() {
            found.push(format!("{prefix}{name}"));
        }
    }
    Ok(())
}

fn hash_all(
    root: &Path,
    names: Vec<String>,
    work: &Work<'_>,
) -> Result<BTreeMap<String, FileFacts>, RunError> {
    let hashed = work.each(names.len(), |_| 1 << 20, |k| hash_file(&root.join(&names[k])))?;
    names.into_iter().zip(hashed).map(|(name, facts)| Ok((name, facts?))).collect()
}

fn hash_file(path: &Path) -> Result<FileFacts, RunError> {
    let unreadable = |e: std::io::Error| RunError {
        exit: ExitCode::InputOutput,
        message: format!("cannot read {}: {e}; check its permissions", path.display()),
    };
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let mut hash = blake3::Hasher::new();
    let mut buffer = vec![0; 256 << 10];
    let mut bytes = 0;
    loop {
        match file.read(&mut buffer).map_err(unreadable)? {
            0 => return Ok(FileFacts { bytes, blake3: hash.finalize().to_hex().to_string() }),
            read => {
                hash.update(&buffer[..read]);
                bytes += read as u64;
            }
        }
    }
}

/// Promise 1: the input is what the run read, every listed output is there with its hash, nothing half-written is left.
pub(super) fn check_files(files: &Files, records: &Records, out: &Path) -> Result<Findings, RunError> {
    let mut findings = Findings::default();
    for input in &records.manifest.inputs {
        findings.count("input files", 1);
        check_listed(input, files.scene.get(&input.path), "the input", &mut findings);
    }
    for output in &records.manifest.outputs {
        findings.count("output files", 1);
        check_listed(output, files.out.get(&output.path), "the output", &mut findings);
    }
    for name in list_files(out, None)? {
        let file = name.rsplit('/').next().unwrap_or(&name);
        if is_temporary(file.as_ref()) {
            findings.offend(format!("{name}: a half-written file is left in OUT"));
        }
    }
    let listed: BTreeSet<&str> = records.manifest.outputs.iter().map(|f| f.path.as_str()).collect();
    let strangers = files.out.keys().filter(|name| !listed.contains(name.as_str())).count();
    if strangers > 0 {
        findings.note(format!("{strangers} files in OUT are not listed in its manifest: not lacuna's"));
    }
    Ok(findings)
}

fn check_listed(listed: &ListedFile, found: Option<&FileFacts>, what: &str, findings: &mut Findings) {
    let name = &listed.path;
    match found {
        None => findings.offend(format!("{name}: {what} is missing")),
        Some(now) if now.bytes != listed.bytes => {
            findings.offend(format!("{name}: {what} has {} bytes, the run saw {}", now.bytes, listed.bytes));
        }
        Some(now) if now.blake3 != listed.blake3 => {
            findings.offend(format!("{name}: {what} has other content than the run saw"));
        }
        Some(_) => {}
    }
}
