//! The figures against work whose size is known. One test after the other in one thread: the counts are the process's.

use lacuna_system as system;

#[global_allocator]
static ALLOCATOR: system::CountingAllocator = system::CountingAllocator;

const MIB: u64 = 1 << 20;
/// Batches of the test's own threads.
const SLACK_BYTES: u64 = MIB;

/// Written page by page, so that it is resident.
fn touched(bytes: u64) -> Vec<u8> {
    std::hint::black_box(vec![1_u8; bytes as usize])
}

fn near(value: u64, expected: u64, name: &str) {
    assert!(value.abs_diff(expected) <= SLACK_BYTES, "{name}: {value} is not near {expected}");
}

fn a_large_block_is_counted_and_given_back() {
    system::reset_peak_allocated();
    let before = system::allocated_bytes();
    let block = touched(40 * MIB);
    near(system::allocated_bytes(), before + 40 * MIB, "in use");
    drop(block);
    near(system::allocated_bytes(), before, "after drop");
    near(system::peak_allocated_bytes(), before + 40 * MIB, "peak");
    system::reset_peak_allocated();
    near(system::peak_allocated_bytes(), before, "peak after reset");
}

fn growth_by_realloc_is_counted_once() {
    let before = system::allocated_bytes();
    let mut column: Vec<u64> = Vec::new();
    column.extend(0..2 * MIB);
    near(system::allocated_bytes(), before + 8 * column.capacity() as u64, "grown");
    column.truncate(10);
    column.shrink_to_fit();
    near(system::allocated_bytes(), before, "shrunk");
}

fn small_blocks_of_other_threads_are_counted() {
    let before = system::allocated_bytes();
    let column: Vec<Box<[u8; 1000]>> = std::thread::scope(|scope| {
        let make = || (0..10_000).map(|_| Box::new([7; 1000])).collect::<Vec<_>>();
        let threads: Vec<_> = (0..2).map(|_| scope.spawn(make)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_default()).collect()
    });
    assert_eq!(column.len(), 20_000);
    assert!(system::allocated_bytes() >= before + 20_000_000 - SLACK_BYTES);
    drop(column);
    near(system::allocated_bytes(), before, "freed by the thread that did not make them");
}

#[cfg(target_os = "linux")]
fn resident_set_follows_the_block() {
    let before = system::current_rss_bytes().unwrap_or(0);
    assert!(before > MIB / 4, "no resident set");
    let block = touched(64 * MIB);
    let with = system::current_rss_bytes().unwrap_or(0);
    assert!(with >= before + 60 * MIB, "{before} -> {with}");
    drop(block);
    assert!(system::peak_rss_bytes().unwrap_or(0) >= with - MIB);
    system::trim();
    if system::reset_peak_rss() {
        assert!(system::peak_rss_bytes().unwrap_or(u64::MAX) < with - 50 * MIB, "the peak was not reset");
    }
}

#[cfg(target_os = "linux")]
fn the_limit_is_a_machine_s() {
    let bytes = system::available_memory_bytes().unwrap_or(0);
    assert!(bytes > system::peak_rss_bytes().unwrap_or(0), "{bytes}");
}

#[cfg(unix)]
fn processor_time_runs() {
    let start = system::cpu_seconds().unwrap_or(-1.0);
    assert!(start >= 0.0);
    let clock = std::time::Instant::now();
    let mut sum = 0_u64;
    while clock.elapsed().as_millis() < 50 {
        sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(7));
    }
    let spent = system::cpu_seconds().unwrap_or(-1.0) - start;
    assert!(spent > 0.0 && spent < 10.0, "{spent} s");
}

#[test]
fn figures() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    assert!(system::limit_arenas(2));
    a_large_block_is_counted_and_given_back();
    growth_by_realloc_is_counted_once();
    small_blocks_of_other_threads_are_counted();
    #[cfg(target_os = "linux")]
    resident_set_follows_the_block();
    #[cfg(target_os = "linux")]
    the_limit_is_a_machine_s();
    #[cfg(unix)]
    processor_time_runs();
}
