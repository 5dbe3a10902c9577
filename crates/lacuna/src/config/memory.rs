//! The memory limit, and what the machine or its control group has.

use serde::{Deserialize, Deserializer};
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A limit as it is written: `512MiB`, `6GB` or `50%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MemoryLimit {
    /// So many bytes.
    Bytes(u64),
    /// A share of what the machine or its control group has, above 0 and at most 100.
    Percent(f64),
}

impl MemoryLimit {
    /// The limit when nothing is said.
    pub const DEFAULT: Self = Self::Percent(50.0);

    /// The limit in bytes on a machine.
    #[must_use]
    pub fn bytes_on(self, machine: &Machine) -> u64 {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Percent(percent) => (machine.memory_bytes as f64 * percent / 100.0) as u64,
        }
    }
}

impl FromStr for MemoryLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        match text.strip_suffix('%') {
            Some(number) => percent(number),
            None => bytes(text),
        }
    }
}

fn percent(number: &str) -> Result<MemoryLimit, String> {
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 100.0 => Ok(MemoryLimit::Percent(value)),
        _ => Err("a share of memory is above 0 % and at most 100 %, such as 50%".to_owned()),
    }
}

fn bytes(text: &str) -> Result<MemoryLimit, String> {
    let help = "write 512MiB, 12GiB, 6GB (6 000 000 000 bytes) or 50%";
    let shown = text.escape_debug();
    if !text.ends_with(|c: char| c.is_ascii_alphabetic()) {
        return Err(format!("`{shown}` has no unit; {help}"));
    }
    match text.parse::<bytesize::ByteSize>() {
        Ok(size) if size.as_u64() > 0 => Ok(MemoryLimit::Bytes(size.as_u64())),
        Ok(_) => Err(format!("`{shown}` is nothing; {help}")),
        Err(_) => Err(format!("`{shown}` is not understood; {help}")),
    }
}

impl<'de> Deserialize<'de> for MemoryLimit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// What a run may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Memory of the machine or the limit of its control group, whichever is less.
    pub memory_bytes: u64,
    /// Processors that the process may use.
    pub threads: usize,
}

impl Machine {
    /// Looks at the machine: `/proc/meminfo`, control groups of version 2 and 1, and the processors allowed. Where
    /// nothing can be read, 4 GiB and one processor are taken.
    #[must_use]
    pub fn detect() -> Self {
        let memory_bytes = memory_under(Path::new("/")).unwrap_or(4 << 30);
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self { memory_bytes, threads }
    }
}

/// The least of what `/proc/meminfo` and the process's control groups say; `root` is `/` but in tests.
fn memory_under(root: &Path) -> Option<u64> {
    let total = fs::read_to_string(root.join("proc/meminfo")).ok().and_then(|text| mem_total(&text));
    let limits = control_group_files(root).into_iter().filter_map(|file| limit_of(&file));
    limits.chain(total).min()
}

fn mem_total(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// Files that may hold a limit: of the process's own group and of every group above it.
fn control_group_files(root: &Path) -> Vec<PathBuf> {
    let groups = fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':');
        let (_, Some(controllers), Some(group)) = (parts.next(), parts.next(), parts.next()) else {
            continue;
        };
        let (mount, name) = match controllers {
            "" => ("sys/fs/cgroup", "memory.max"),
            other if other.split(',').any(|c| c == "memory") => {
                ("sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let relative = Path::new(group.trim_start_matches('/'));
        files.extend(relative.ancestors().map(|above| root.join(mount).join(above).join(name)));
    }
    files
}

fn limit_of(file: &Path) -> Option<u64> {
    // "max" (version 2) is no number; "no limit" of version 1 is a huge one and loses against the machine's memory.
    fs::read_to_string(file).ok()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::{MemoryLimit, memory_under};
    use std::fs;
    use std::path::Path;

    #[test]
    fn reads_sizes_and_shares() {
        for (text, expected) in [
            ("512MiB", MemoryLimit::Bytes(512 << 20)),
            (" 6GB ", MemoryLimit::Bytes(6_000_000_000)),
            ("1.5 GiB", MemoryLimit::Bytes(3 << 29)),
            ("50%", MemoryLimit::Percent(50.0)),
            ("12.5 %", MemoryLimit::Percent(12.5)),
        ] {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
        for text in ["", "12", "12 gigs", "-5MiB", "0%", "101%", "%", "0GiB", "NaN%"] {
            assert!(text.parse::<MemoryLimit>().is_err(), "{text}");
        }
    }

    fn write(root: &Path, name: &str, text: &str) {
        let path = root.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a temporary folder");
        fs::write(path, text).expect("a temporary file");
    }

    #[test]
    fn the_smallest_limit_counts() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let root = root.path();
        assert_eq!(memory_under(root), None);
        write(root, "proc/meminfo", "MemFree: 1 kB\nMemTotal:       16 kB\n");
        assert_eq!(memory_under(root), Some(16 << 10));
        write(root, "proc/self/cgroup", "0::/user/job\n");
        write(root, "sys/fs/cgroup/user/job/memory.max", "max\n");
        assert_eq!(memory_under(root), Some(16 << 10));
        write(root, "sys/fs/cgroup/user/memory.max", "9000\n");
        assert_eq!(memory_under(root), Some(9000));
        write(root, "proc/self/cgroup", "5:cpu,memory:/docker/x\n1:cpu:/y\n");
        write(root, "sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
        assert_eq!(memory_under(root), Some(16 << 10));
        write(root, "sys/fs/cgroup/memory/docker/x/memory.limit_in_bytes", "8000\n");
        assert_eq!(memory_under(root), Some(8000));
    }
}
