//! Scenes for tests, each in a folder of its own and watched: no test may leave its input changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use tempfile::TempDir;

/// A scene in a temporary folder. When it is dropped, files, bytes and times must be those of the last `seal`.
pub(crate) struct SceneFolder {
    folder: TempDir,
    path: PathBuf,
    sealed: State,
}

/// Length, time of the last change and bytes of every file; folders and odd files with length 0.
type State = BTreeMap<PathBuf, (u64, Option<SystemTime>, Vec<u8>)>;

/// A copy of the small scene of testdata: 3 x 3 cells, 11 holes.
pub(crate) fn small() -> SceneFolder {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes/small");
    SceneFolder::new(|path| copy_tree(&source, path))
}

/// Copies a folder with all that is in it.
pub(crate) fn copy_tree(source: &Path, target: &Path) {
    std::fs::create_dir_all(target).expect("a folder");
    for entry in std::fs::read_dir(source).expect("a folder") {
        let entry = entry.expect("an entry");
        let to = target.join(entry.file_name());
        if entry.file_type().expect("a kind").is_dir() {
            copy_tree(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), &to).expect("a copy");
        }
    }
}

impl SceneFolder {
    /// A scene that `make` writes into a path that does not exist yet.
    pub(crate) fn new(make: impl FnOnce(&Path)) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("scene");
        make(&path);
        let sealed = state(&path);
        Self { folder, path, sealed }
    }

    /// The same scene with damage done to it.
    pub(crate) fn changed(mut self, damage: impl FnOnce(&Path)) -> Self {
        damage(&self.path);
        self.sealed = state(&self.path);
        self
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// A path beside the scene.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The file of a tile of the small scene.
    pub(crate) fn tile(&self, name: &str) -> PathBuf {
        tile_of(&self.path, name)
    }
}

/// The file of a tile, `Tile_+000_+001/Tile_+000_+001.ply`.
pub(crate) fn tile_of(scene: &Path, name: &str) -> PathBuf {
    scene.join(name).join(name).with_extension("ply")
}

impl Drop for SceneFolder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert!(self.sealed == state(&self.path), "a run changed its input");
        }
    }
}

fn state(root: &Path) -> State {
    let mut state = State::new();
    let mut paths = vec![root.to_owned()];
    while let Some(path) = paths.pop() {
        let facts = std::fs::symlink_metadata(&path).expect("facts");
        if facts.is_dir() {
            paths.extend(std::fs::read_dir(&path).expect("a folder").map(|e| e.expect("an entry").path()));
        }
        let bytes = if facts.is_file() { std::fs::read(&path).unwrap_or_default() } else { Vec::new() };
        let length = if facts.is_file() { facts.len() } else { 0 };
        state.insert(path, (length, facts.modified().ok(), bytes));
    }
    state
}
