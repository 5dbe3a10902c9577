//! Any list of jobs, any limit that suffices, any number of threads.

use lacuna_schedule::{Job, JobResult, MemoryBudget, Pool, StopFlag};
use proptest::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_job_ends_once_within_the_limit(
        sizes in prop::collection::vec((0_u64..5, 0_u64..50), 0..60),
        room in 0_u64..100,
        threads in 1_usize..5,
        bad in 0_usize..60,
    ) {
        let jobs: Vec<Job> = sizes.iter().map(|&(key, bytes)| Job { key, bytes }).collect();
        let limit = jobs.iter().map(|job| job.bytes).max().unwrap_or(0) + room;
        let (now, peak) = (AtomicU64::new(0), AtomicU64::new(0));
        let runs: Vec<AtomicU64> = jobs.iter().map(|_| AtomicU64::new(0)).collect();
        let work = |index: usize| {
            let used = now.fetch_add(jobs[index].bytes, SeqCst) + jobs[index].bytes;
            peak.fetch_max(used, SeqCst);
            std::thread::yield_now();
            now.fetch_sub(jobs[index].bytes, SeqCst);
            assert_ne!(index, bad);
            index
        };
        let done = |index: usize| {
            runs[index].fetch_add(1, SeqCst);
        };
        let pool = Pool::new(threads).expect("threads");
        let budget = MemoryBudget::new(limit);
        let results = pool.run(&jobs, &budget, &StopFlag::new(), work, done).expect("every job fits");
        prop_assert!(peak.load(SeqCst) <= limit);
        prop_assert_eq!(budget.lent_bytes(), 0);
        prop_assert!(runs.iter().all(|count| count.load(SeqCst) == 1));
        for (index, result) in results.iter().enumerate() {
            match result {
                JobResult::Done(value) => prop_assert!(*value == index && index != bad),
                JobResult::Panicked(_) => prop_assert_eq!(index, bad),
                JobResult::Stopped => prop_assert!(false, "nobody stopped"),
            }
        }
    }
}
