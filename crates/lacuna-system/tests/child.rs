//! A child's end, memory, processor time and traffic against what it is known to do.
#![cfg(target_os = "linux")]

use lacuna_system::{ChildUsage, WatchedChild, transferred_bytes};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const MIB: u64 = 1 << 20;

fn shell(script: &str) -> WatchedChild {
    let mut command = Command::new("sh");
    WatchedChild::spawn(command.args(["-c", script]).stdout(Stdio::null())).expect("a shell")
}

/// Polls until the child has ended; a minute is far more than any of them needs.
fn end(child: &mut WatchedChild) -> ChildUsage {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        if let Some(usage) = child.poll().expect("a child") {
            return usage;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("the child does not end");
}

/// A grandchild goes with its parent; one that nobody has waited for yet counts as gone.
#[test]
fn what_a_child_started_is_killed_with_it() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let note = folder.path().join("id");
    let mut child =
        shell(&format!("sleep 60 & echo $! > '{}.part' && mv '{0}.part' '{0}'; wait", note.display()));
    let start = Instant::now();
    let id = loop {
        match std::fs::read_to_string(&note) {
            Ok(id) => break id.trim().to_owned(),
            Err(_) if start.elapsed() < Duration::from_secs(60) => {
                std::thread::sleep(Duration::from_millis(5))
            }
            Err(e) => panic!("the child starts nothing: {e}"),
        }
    };
    let is_gone =
        || std::fs::read_to_string(format!("/proc/{id}/stat")).map_or(true, |stat| stat.contains(") Z "));
    assert!(!is_gone(), "it sleeps");
    child.kill().expect("a child of our own");
    end(&mut child);
    while !is_gone() {
        assert!(start.elapsed() < Duration::from_secs(60), "it sleeps on");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// One test, for what is read and written is counted for the whole process.
#[test]
fn a_child_is_what_it_was_told_to_be() {
    let mut quick = shell("exit 7");
    assert_eq!(end(&mut quick).status.code(), Some(7));
    assert_eq!(end(&mut quick).status.code(), Some(7), "asked again");
    assert!(quick.kill().is_ok(), "an ended child is not killed, nor anybody else");

    let mut slow = shell("exec sleep 60");
    assert!(slow.poll().expect("a child").is_none());
    slow.kill().expect("a child of our own");
    assert_eq!(end(&mut slow).status.code(), None, "ended by a signal");

    let mut busy = shell("i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done");
    let mut seen_bytes = 0;
    while busy.poll().expect("a child").is_none() {
        seen_bytes = busy.resident().map_or(seen_bytes, |r| seen_bytes.max(r.peak_bytes));
    }
    assert!((MIB / 8..64 * MIB).contains(&seen_bytes), "{seen_bytes}");
    assert!(end(&mut busy).cpu_seconds.is_some_and(|s| s > 0.01), "{:?}", end(&mut busy));
    assert!(busy.resident().is_none(), "gone");

    let before = transferred_bytes().expect("/proc/self/io");
    let mut copying = shell("head -c 5242880 /dev/zero | cat > /dev/null");
    assert!(end(&mut copying).status.success());
    let after = transferred_bytes().expect("/proc/self/io");
    let (read, written) = (after.read_bytes - before.read_bytes, after.written_bytes - before.written_bytes);
    assert!((10 * MIB..11 * MIB).contains(&read), "a grandchild counts: {read}");
    assert!((10 * MIB..11 * MIB).contains(&written), "{written}");
}
