//! Files appear whole or not at all.

mod common;

use common::Folder;
use lacuna_tile::{AtomicFile, CopyMode, Hashing, TileError, copy_file, is_temporary, sync_directory};
use std::fs;
use std::io::Write;

#[test]
fn an_uncommitted_file_leaves_nothing() {
    let folder = Folder::new();
    {
        let mut file = AtomicFile::create(&folder.path("tile.obj")).expect("create");
        file.write_all(&[7; 1_000_000]).expect("write");
        let names = folder.names();
        assert_eq!(names.len(), 1, "only the temporary file: {names:?}");
        assert!(is_temporary(names[0].as_ref()), "{names:?}");
    }
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn an_existing_target_is_replaced_whole() {
    let folder = Folder::new();
    let target = folder.write("tile.obj", "a much longer earlier content");
    let mut file = AtomicFile::create(&target).expect("create");
    file.write_all(b"new").expect("write");
    assert_eq!(
        fs::read(&target).expect("read"),
        b"a much longer earlier content",
        "untouched until the commit"
    );
    let committed = file.commit().expect("commit");
    assert_eq!(fs::read(&target).expect("read"), b"new");
    assert_eq!((committed.bytes, committed.hash), (3, *blake3::hash(b"new").as_bytes()));
    assert_eq!(folder.names(), ["tile.obj"]);
}

#[test]
fn a_commit_that_fails_leaves_the_target_and_no_temporary_file() {
    let folder = Folder::new();
    let target = folder.path("tile.obj");
    fs::create_dir(&target).expect("folder in the way");
    let mut file = AtomicFile::create(&target).expect("create");
    file.write_all(b"new").expect("write");
    let error = file.commit().expect_err("a folder can't be replaced");
    assert!(matches!(&error, TileError::Io { operation: "rename the temporary file to", .. }), "{error}");
    assert!(error.errno().is_some(), "{error}");
    assert_eq!(folder.names(), ["tile.obj"]);
}

#[test]
fn a_missing_folder_is_named() {
    let folder = Folder::new();
    let error = AtomicFile::create(&folder.path("absent/tile.obj")).expect_err("no folder");
    assert_eq!(error.path(), folder.path("absent/tile.obj"));
    assert_eq!(error.errno(), Some(2));
    assert!(!error.to_string().contains(".lacuna-"), "no random name in a message: {error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_files_is_named_with_its_number() {
    let folder = Folder::new();
    let from = folder.write("from", "content");
    let error =
        copy_file(&from, "/proc/lacuna".as_ref(), CopyMode::Copy, Hashing::Yes).expect_err("no files there");
    assert!(matches!(&error, TileError::Io { .. }) && error.errno().is_some(), "{error}");
}

/// Its first bytes are no memory of the process: reading them fails, opening does not.
#[cfg(target_os = "linux")]
#[test]
fn a_copy_that_fails_names_the_side_that_refused() {
    let folder = Folder::new();
    let (bad, to) = (std::path::Path::new("/proc/self/mem"), folder.path("to"));
    let error = copy_file(bad, &to, CopyMode::Copy, Hashing::Yes).expect_err("unreadable");
    assert_eq!(error.path(), bad, "{error}");
    assert!(!to.exists());
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_any_new_file() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let plain = folder.write("plain", "");
    AtomicFile::create(&folder.path("atomic")).expect("create").commit().expect("commit");
    let mode = |path| fs::metadata(path).expect("metadata").permissions().mode();
    assert_eq!(mode(folder.path("atomic")), mode(plain));
}

#[cfg(unix)]
#[test]
fn a_link_in_the_way_is_replaced_not_followed() {
    let folder = Folder::new();
    let victim = folder.write("victim", "keep me");
    std::os::unix::fs::symlink(&victim, folder.path("tile.obj")).expect("link");
    let mut file = AtomicFile::create(&folder.path("tile.obj")).expect("create");
    file.write_all(b"new").expect("write");
    file.commit().expect("commit");
    assert_eq!(fs::read(&victim).expect("read"), b"keep me");
    assert_eq!(fs::read(folder.path("tile.obj")).expect("read"), b"new");
}

#[test]
fn copies_are_the_same_bytes_in_every_mode() {
    let folder = Folder::new();
    for length in [0, 1, 700_000] {
        let content: Vec<u8> = (0..length).map(|k: u32| (k % 251) as u8).collect();
        let from = folder.write("from", &content);
        for mode in [CopyMode::Copy, CopyMode::Reflink] {
            for hashing in [Hashing::Yes, Hashing::No] {
                let to = folder.write("to", "earlier");
                let copied = copy_file(&from, &to, mode, hashing).expect("copy");
                assert_eq!(fs::read(&to).expect("read"), content, "{mode:?} {hashing:?}");
                assert_eq!(copied.bytes, u64::from(length));
                let want = (hashing == Hashing::Yes).then(|| *blake3::hash(&content).as_bytes());
                assert_eq!(copied.hash, want, "{mode:?} {hashing:?}");
            }
        }
    }
    assert_eq!(folder.names(), ["from", "to"]);
}

#[test]
fn folders_and_absent_files_are_not_copied() {
    let folder = Folder::new();
    let to = folder.path("to");
    let copy = |from: &str| copy_file(&folder.path(from), &to, CopyMode::Copy, Hashing::No);
    assert!(matches!(copy("absent"), Err(TileError::Io { operation: "open", .. })));
    assert!(matches!(copy(""), Err(TileError::Unsupported { .. })));
    assert_eq!(folder.names(), Vec::<String>::new());
}

#[test]
fn folders_are_synchronised() {
    let folder = Folder::new();
    sync_directory(&folder.path("")).expect("sync");
    assert!(sync_directory(&folder.path("absent")).is_err());
}
