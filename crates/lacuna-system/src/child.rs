//! A child process that is watched while it runs: its memory, and at the end its processor time.

use crate::process::kib_field;
use std::io;
use std::process::{Child, Command, ExitStatus};

/// A running child. It is not stopped when this is dropped.
#[derive(Debug)]
pub struct WatchedChild {
    child: Child,
    ended: Option<ChildUsage>,
}

/// How a child ended and what it used, all threads and all children that it waited for counted in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChildUsage {
    /// Exit code or signal.
    pub status: ExitStatus,
    /// Processor time, user and system together, seconds; `None` where the platform does not tell.
    pub cpu_seconds: Option<f64>,
    /// Largest resident set, bytes; `None` where the platform does not tell. Linux counts in what the parent itself had
    /// resident at most when it started the child: a value no larger than the parent's own peak says nothing.
    pub peak_rss_bytes: Option<u64>,
}

/// Resident memory of a running process, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResidentMemory {
    /// Now (`VmRSS`).
    pub now_bytes: u64,
    /// At most so far (`VmHWM`).
    pub peak_bytes: u64,
}

impl WatchedChild {
    /// Starts a child, on Unix as the head of a process group: what it starts itself ends with it.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { child: command.spawn()?, ended: None })
    }

    /// Resident memory now; `None` where there is no `/proc`, and once the child has ended.
    #[must_use]
    pub fn resident(&self) -> Option<ResidentMemory> {
        if self.ended.is_some() {
            return None;
        }
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        Some(ResidentMemory {
            now_bytes: kib_field(&status, "VmRSS")?,
            peak_bytes: kib_field(&status, "VmHWM")?,
        })
    }

    /// What the child used, if it has ended; never waits.
    ///
    /// # Errors
    /// The system does not tell.
    pub fn poll(&mut self) -> io::Result<Option<ChildUsage>> {
        if self.ended.is_none() {
            self.ended = reap(&mut self.child)?;
        }
        Ok(self.ended)
    }

    /// Kills the child and all that it has started, unless it has ended; [`WatchedChild::poll`] then tells its end soon.
    ///
    /// # Errors
    /// The system refuses.
    pub fn kill(&mut self) -> io::Result<()> {
        // Once it was waited for, its number may belong to another process.
        if self.ended.is_some() { Ok(()) } else { kill_group(&mut self.child) }
    }
}

#[cfg(unix)]
fn kill_group(child: &mut Child) -> io::Result<()> {
    let id = libc::pid_t::try_from(child.id()).map_err(io::Error::other)?;
    // SAFETY: takes two numbers. The group is the child's own: its head has not been waited for, so the number is not
    // another's.
    match unsafe { libc::killpg(id, libc::SIGKILL) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

#[cfg(not(unix))]
fn kill_group(child: &mut Child) -> io::Result<()> {
    child.kill()
}

#[cfg(unix)]
fn reap(child: &mut Child) -> io::Result<Option<ChildUsage>> {
    use std::os::unix::process::ExitStatusExt;
    let id = libc::pid_t::try_from(child.id()).map_err(io::Error::other)?;
    let mut status = 0;
    let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
    // SAFETY: both pointers are to live, writable values of the types that the call fills in; the child was started by
    // this process and is waited for nowhere else.
    let waited = unsafe { libc::wait4(id, &raw mut status, libc::WNOHANG, usage.as_mut_ptr()) };
    match waited {
        0 => Ok(None),
        -1 => Err(io::Error::last_os_error()),
        _ => {
            // SAFETY: `rusage` is numbers only, for which the zeroes it was made of are valid; the call filled them in.
            let usage = unsafe { usage.assume_init() };
            let kib = if cfg!(target_os = "macos") { 1 } else { 1024 };
            Ok(Some(ChildUsage {
                status: ExitStatus::from_raw(status),
                cpu_seconds: Some(crate::process::cpu_of(&usage)),
                peak_rss_bytes: u64::try_from(usage.ru_maxrss).ok().map(|size| size * kib),
            }))
        }
    }
}

#[cfg(not(unix))]
fn reap(child: &mut Child) -> io::Result<Option<ChildUsage>> {
    let ended = child.try_wait()?;
    Ok(ended.map(|status| ChildUsage { status, cpu_seconds: None, peak_rss_bytes: None }))
}

/// What a process has read and written so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransferredBytes {
    /// Handed to the program by read calls, from cache or disk; mapped files do not count.
    pub read_bytes: u64,
    /// Taken from the program by write calls.
    pub written_bytes: u64,
}

/// What this process and all children that it has waited for have read and written (`/proc/self/io`); `None` where the
/// kernel does not tell. The difference before and after a child is the child's, and the little of this process.
#[must_use]
pub fn transferred_bytes() -> Option<TransferredBytes> {
    let text = std::fs::read_to_string("/proc/self/io").ok()?;
    Some(TransferredBytes { read_bytes: count(&text, "rchar")?, written_bytes: count(&text, "wchar")? })
}

/// The value of a line `name: 123`.
fn count(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?.trim().parse().ok()
}
