//! What a run of jobs promises.

use lacuna_schedule::{Job, JobResult, MemoryBudget, Pool, StopFlag, TooSmall};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

fn pool(threads: usize) -> Pool {
    Pool::new(threads).expect("threads")
}

fn jobs(sizes: &[u64]) -> Vec<Job> {
    sizes.iter().enumerate().map(|(index, &bytes)| Job { key: index as u64, bytes }).collect()
}

/// Runs `body` and fails, instead of waiting for ever, if it does not end.
fn within_a_minute<T: Send + 'static>(body: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(body()));
    receiver.recv_timeout(Duration::from_secs(60)).expect("the run hangs or panicked")
}

/// A mix of sizes from 1 to 100, always the same.
fn mixed_sizes(count: u64) -> Vec<u64> {
    (0..count).map(|i| 1 + (i * 7919 + 13) % 100).collect()
}

#[test]
fn the_limit_is_never_exceeded() {
    for (threads, limit) in [(1, 100), (2, 100), (4, 100), (4, 150), (8, 250)] {
        let jobs = jobs(&mixed_sizes(200));
        let (now, peak) = (AtomicU64::new(0), AtomicU64::new(0));
        let work = |index: usize| {
            let used = now.fetch_add(jobs[index].bytes, SeqCst) + jobs[index].bytes;
            peak.fetch_max(used, SeqCst);
            std::thread::sleep(Duration::from_micros(50));
            now.fetch_sub(jobs[index].bytes, SeqCst);
        };
        let budget = MemoryBudget::new(limit);
        let results = pool(threads).run(&jobs, &budget, &StopFlag::new(), work, |_| {});
        assert_eq!(results.map(|results| results.len()), Ok(200));
        assert!(peak.load(SeqCst) <= limit, "{threads} threads used {} of {limit}", peak.load(SeqCst));
        assert!(budget.peak_lent_bytes() <= limit);
        assert_eq!(budget.lent_bytes(), 0, "all bytes come back");
    }
}

#[test]
fn jobs_that_fit_together_run_together() {
    let barrier = std::sync::Barrier::new(2);
    let barrier = std::sync::Arc::new(barrier);
    let leaders = within_a_minute(move || {
        let budget = MemoryBudget::new(100);
        let work = |_| barrier.wait().is_leader();
        pool(2).run(&jobs(&[50, 50]), &budget, &StopFlag::new(), work, |_| {})
    });
    let leaders = leaders.expect("fits");
    assert_eq!(leaders.iter().filter(|&result| *result == JobResult::Done(true)).count(), 1);
}

#[test]
fn results_do_not_depend_on_threads_or_memory() {
    let jobs = jobs(&mixed_sizes(100));
    let work = |index: usize| (0..index).fold(index as u64, |sum, i| sum.wrapping_mul(31) ^ i as u64);
    let expected: Vec<_> = (0..100).map(|index| JobResult::Done(work(index))).collect();
    for threads in [1, 2, 3, 8] {
        for limit in [100, 200, u64::MAX] {
            let budget = MemoryBudget::new(limit);
            let results = pool(threads).run(&jobs, &budget, &StopFlag::new(), work, |_| {});
            assert_eq!(results.as_ref(), Ok(&expected), "{threads} threads, limit {limit}");
        }
    }
}

#[test]
fn the_biggest_job_starts_first_and_ties_go_by_key_then_index() {
    // More than half of the limit each, so one runs at a time and the order of starts is the order of admission.
    let sized = |(key, bytes)| Job { key, bytes };
    let jobs = [(9, 60), (4, 80), (3, 80), (7, 51), (3, 80), (0, 100)].map(sized);
    for threads in [1, 4] {
        let started = Mutex::new(Vec::new());
        let work = |index| started.lock().expect("no panic").push(index);
        let results = pool(threads).run(&jobs, &MemoryBudget::new(100), &StopFlag::new(), work, |_| {});
        assert!(results.is_ok());
        assert_eq!(started.into_inner().expect("no panic"), [5, 2, 4, 1, 0, 3], "{threads} threads");
    }
}

#[test]
fn two_hundred_jobs_pass_a_limit_of_one() {
    let results = within_a_minute(|| {
        pool(4).run(&jobs(&[1; 200]), &MemoryBudget::new(1), &StopFlag::new(), |index| index, |_| {})
    });
    let expected: Vec<_> = (0..200).map(JobResult::Done).collect();
    assert_eq!(results, Ok(expected));
}

#[test]
fn no_jobs_are_no_work() {
    let never = |_| -> () { unreachable!("there is no job") };
    let results = pool(2).run(&[], &MemoryBudget::new(0), &StopFlag::new(), never, |_| {});
    assert_eq!(results, Ok(Vec::new()));
}

#[test]
fn a_job_above_the_limit_is_refused_before_anything_starts() {
    for (sizes, limit, index, needed) in
        [(vec![5, 101, 200, 7], 100, 2, 200), (vec![1], 0, 0, 1), (vec![9, 9], 8, 0, 9)]
    {
        let started = AtomicUsize::new(0);
        let work = |_| started.fetch_add(1, SeqCst);
        let budget = MemoryBudget::new(limit);
        let refused = pool(2).run(&jobs(&sizes), &budget, &StopFlag::new(), work, |_| {});
        assert_eq!(refused, Err(TooSmall { index, needed_bytes: needed, limit_bytes: limit }));
        assert_eq!(started.load(SeqCst), 0);
        // The limit that the message names is enough.
        assert!(
            pool(2).run(&jobs(&sizes), &MemoryBudget::new(needed), &StopFlag::new(), work, |_| {}).is_ok()
        );
    }
}

#[test]
fn a_panic_is_the_record_of_its_job_alone() {
    let finished = Mutex::new(Vec::new());
    let work = |index: usize| match index {
        3 => panic!("rim without end"),
        5 => panic!("face {} of {}", 7, 2),
        8 => std::panic::panic_any(42_u8),
        _ => index * 10,
    };
    let done = |index| finished.lock().expect("no panic").push(index);
    let budget = MemoryBudget::new(10);
    let results =
        pool(3).run(&jobs(&[4; 12]), &budget, &StopFlag::new(), work, done).expect("every job fits");
    for (index, result) in results.iter().enumerate() {
        let expected = match index {
            3 => "rim without end",
            5 => "face 7 of 2",
            8 => "a panic without a message",
            _ => {
                assert_eq!(*result, JobResult::Done(index * 10));
                continue;
            }
        };
        let JobResult::Panicked(message) = result else { panic!("job {index}: {result:?}") };
        assert!(message.starts_with(expected) && message.contains("run.rs:"), "job {index}: {message}");
    }
    assert_eq!(budget.lent_bytes(), 0, "a panic gives its bytes back");
    let mut finished = finished.into_inner().expect("no panic");
    finished.sort_unstable();
    assert_eq!(finished, (0..12).collect::<Vec<_>>(), "done is called once for every job that ended");
}

#[test]
fn a_panic_in_done_reaches_the_caller_after_the_other_jobs() {
    let (budget, ended) = (MemoryBudget::new(10), AtomicUsize::new(0));
    let run = || {
        let done = |index| assert!(index != 2, "journal closed");
        let work = |_| ended.fetch_add(1, SeqCst);
        pool(2).run(&jobs(&[10; 6]), &budget, &StopFlag::new(), work, done)
    };
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    assert_eq!((ended.load(SeqCst), budget.lent_bytes()), (6, 0));
}

#[test]
fn stop_lets_running_jobs_finish_and_starts_no_more() {
    for (threads, limit) in [(1, 5), (1, 1000), (4, 5), (4, 1000)] {
        let (stop, ended) = (StopFlag::new(), AtomicUsize::new(0));
        let work = |index: usize| {
            if index == 2 {
                stop.stop();
            }
            while index > 2 && !stop.is_stopped() {
                std::thread::yield_now();
            }
            index
        };
        let done = |_| {
            ended.fetch_add(1, SeqCst);
        };
        let results =
            pool(threads).run(&jobs(&[5; 100]), &MemoryBudget::new(limit), &stop, work, done).expect("fits");
        let finished = results.iter().filter(|result| matches!(result, JobResult::Done(_))).count();
        let stopped = results.iter().filter(|result| matches!(result, JobResult::Stopped)).count();
        assert_eq!(results[2], JobResult::Done(2), "the job that raised the flag ends");
        assert_eq!(finished + stopped, 100);
        assert_eq!(finished, ended.load(SeqCst), "done is not called for jobs that never started");
        assert!(finished <= 2 + threads, "{finished} jobs ran on {threads} threads");
    }
}

#[test]
fn a_raised_flag_starts_nothing() {
    let stop = StopFlag::new();
    stop.shared().store(true, SeqCst);
    let never = |_| -> () { unreachable!("the flag is raised") };
    let results = pool(2).run(&jobs(&[1; 5]), &MemoryBudget::new(9), &stop, never, |_| {});
    assert_eq!(results, Ok(vec![JobResult::Stopped; 5]));
}

#[test]
fn workers_have_room_for_deep_recursion() {
    #[inline(never)]
    fn descend(depth: usize) -> u64 {
        let frame = [depth as u8; 16 << 10];
        std::hint::black_box(&frame);
        if depth == 0 { 0 } else { descend(depth - 1) + u64::from(std::hint::black_box(&frame)[7] > 0) }
    }
    // 400 frames of 16 KiB are 6.25 MiB.
    let results = pool(1).run(&jobs(&[1]), &MemoryBudget::new(1), &StopFlag::new(), |_| descend(400), |_| {});
    assert!(matches!(results.as_deref(), Ok([JobResult::Done(count)]) if *count > 300));
}

#[test]
fn zero_threads_are_as_many_as_the_machine_has() {
    assert_eq!(pool(3).thread_count(), 3);
    let machine = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
    assert_eq!(pool(0).thread_count(), machine);
}
