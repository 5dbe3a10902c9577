//! Resident memory and processor time of this process.

/// Largest resident set of this process so far (`VmHWM` of `/proc/self/status`), bytes; `None` where there is no `/proc`.
#[must_use]
pub fn peak_rss_bytes() -> Option<u64> {
    kib_field(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM")
}

/// Resident set of this process now (`VmRSS` of `/proc/self/status`), bytes; `None` where there is no `/proc`.
#[must_use]
pub fn current_rss_bytes() -> Option<u64> {
    kib_field(&std::fs::read_to_string("/proc/self/status").ok()?, "VmRSS")
}

/// Makes the present resident set the peak, for a peak per stage. Returns false where the kernel does not allow it
/// (no `/proc`, or `clear_refs` read-only); the peak is then that of the whole run.
pub fn reset_peak_rss() -> bool {
    use std::io::Write;
    // Opened without `create`: elsewhere than on Linux no stray file may appear.
    let opened = std::fs::OpenOptions::new().write(true).open("/proc/self/clear_refs");
    opened.is_ok_and(|mut file| file.write_all(b"5").is_ok())
}

/// Gives freed memory back to the system (`malloc_trim`), for the limit counts what is resident. Returns true if some
/// was given back; does nothing where the C library is not glibc.
pub fn trim() -> bool {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: takes a number, may be called at any time from any thread, and frees only what is free already.
        unsafe { libc::malloc_trim(0) == 1 }
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    false
}

/// Limits glibc's heaps to `count`, so that freed memory of one thread serves the others. To be called before the first
/// thread starts. Returns true if the limit holds; does nothing where the C library is not glibc.
pub fn limit_arenas(count: u8) -> bool {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: sets one number of the allocator under its own lock; existing blocks stay where they are.
        unsafe { libc::mallopt(libc::M_ARENA_MAX, libc::c_int::from(count)) == 1 }
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    {
        let _ = count;
        false
    }
}

/// Processor time of all threads of this process, user and system together, seconds; `None` where the platform has no
/// `getrusage`.
#[must_use]
pub fn cpu_seconds() -> Option<f64> {
    #[cfg(unix)]
    {
        let mut usage = std::mem::MaybeUninit::<libc::rusage>::zeroed();
        // SAFETY: the pointer is to a live, writable `rusage`, all that the call asks for.
        let status = unsafe { libc::getrusage(libc::RUSAGE_SELF, usage.as_mut_ptr()) };
        // SAFETY: `rusage` is numbers only, for which the zeroes it was made of are valid even if the call failed.
        let usage = unsafe { usage.assume_init() };
        (status == 0).then(|| cpu_of(&usage))
    }
    #[cfg(not(unix))]
    None
}

/// User and system time together, seconds.
#[cfg(unix)]
pub(crate) fn cpu_of(usage: &libc::rusage) -> f64 {
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

#[cfg(unix)]
fn seconds(time: libc::timeval) -> f64 {
    time.tv_sec as f64 + time.tv_usec as f64 * 1e-6
}

/// The value of a line `Name:   123 kB`, bytes.
pub(crate) fn kib_field(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    kib.checked_mul(1024)
}
