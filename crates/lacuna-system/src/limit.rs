//! How much memory this process may use at all.

use crate::process::kib_field;
use std::path::Path;

/// Memory that the machine or the control group gives this process, bytes: the smallest of the machine's memory
/// (`MemTotal`) and the limits of the process's control group and of all groups above it (version 2 `memory.max`,
/// version 1 `memory.limit_in_bytes`). `None` where the platform tells neither.
///
/// What other processes use now is not taken off: a default that changes with the neighbours would not repeat.
#[must_use]
pub fn available_memory_bytes() -> Option<u64> {
    let machine = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| kib_field(&text, "MemTotal"));
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = group_limit_bytes(Path::new("/sys/fs/cgroup"), &groups);
    machine.into_iter().chain(group).min()
}

/// The smallest limit of the groups that `groups` (the text of `/proc/self/cgroup`) names, bytes.
fn group_limit_bytes(root: &Path, groups: &str) -> Option<u64> {
    groups.lines().filter_map(|line| line_limit_bytes(root, line)).min()
}

/// The smallest limit along the path of one line `id:controllers:/path`, bytes.
fn line_limit_bytes(root: &Path, line: &str) -> Option<u64> {
    let mut fields = line.splitn(3, ':').skip(1);
    let (controllers, path) = (fields.next()?, fields.next()?.trim_start_matches('/'));
    if controllers.is_empty() {
        smallest_upwards(root, path, "memory.max")
    } else if controllers.split(',').any(|name| name == "memory") {
        smallest_upwards(&root.join("memory"), path, "memory.limit_in_bytes")
    } else {
        None
    }
}

/// The smallest number in the files `name` of the folder `root/path` and of all folders above it up to `root`. In a
/// container the path is often the host's and does not exist: then the files of `root` itself decide.
fn smallest_upwards(root: &Path, path: &str, name: &str) -> Option<u64> {
    Path::new(path)
        .ancestors()
        .filter_map(|folder| std::fs::read_to_string(root.join(folder).join(name)).ok())
        .filter_map(|text| text.trim().parse().ok())
        .min()
}

#[cfg(test)]
mod tests {
    use super::group_limit_bytes;
    use std::path::Path;

    /// One file tree for all cases; "max" is version 2's word for no limit.
    fn groups() -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder for the test");
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).expect("folder");
            std::fs::write(path, text).expect("file");
        };
        write("a/memory.max", "3000\n");
        write("a/b/memory.max", "max\n");
        write("a/b/c/memory.max", "5000\n");
        write("memory/memory.limit_in_bytes", "9223372036854771712\n");
        write("memory/job/memory.limit_in_bytes", "700\n");
        root
    }

    #[test]
    fn the_smallest_limit_upwards_holds() {
        let root = groups();
        for (name, text, expected) in [
            ("own limit is lifted by none above", "0::/a/b/c", Some(3000)),
            ("no limit of its own", "0::/a/b", Some(3000)),
            ("outside of every group", "0::/", None),
            ("a path of the host", "0::/docker/1234", None),
            ("version 1", "7:cpu,memory:/job\n3:cpu:/job", Some(700)),
            ("version 1, path of the host", "7:memory:/docker/1", Some(9_223_372_036_854_771_712)),
            ("version 1 without memory", "7:cpu:/job", None),
            ("both versions", "7:memory:/job\n0::/a/b/c", Some(700)),
            ("not a group file", "nonsense\n\n::", None),
        ] {
            assert_eq!(group_limit_bytes(root.path(), text), expected, "{name}");
        }
    }
}
