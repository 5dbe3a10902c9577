//! A job's panic belongs into its record, not on the terminal; any other panic is printed as ever.

use lacuna_schedule::{Job, JobResult, MemoryBudget, Pool, StopFlag};
use std::process::Command;

#[test]
#[ignore = "run by the test below, in a process of its own"]
fn child() {
    let pool = Pool::new(2).expect("threads");
    let jobs = [Job { key: 0, bytes: 1 }; 2];
    let work = |index: usize| assert!(index == 0, "inside a job");
    let results = pool.run(&jobs, &MemoryBudget::new(2), &StopFlag::new(), work, |_| {}).expect("fits");
    assert!(matches!(results[1], JobResult::Panicked(_)));
    let done = |_| panic!("after a job");
    let run = || pool.run(&jobs, &MemoryBudget::new(2), &StopFlag::new(), |_| {}, done);
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
    let outside = std::thread::spawn(|| panic!("outside of jobs")).join();
    assert!(outside.is_err());
}

#[test]
fn only_panics_outside_of_jobs_are_printed() {
    let output = Command::new(std::env::current_exe().expect("this test"))
        .args(["--ignored", "--exact", "child", "--nocapture"])
        .output()
        .expect("start this test again");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}");
    assert!(printed.contains("outside of jobs"), "{printed}");
    assert!(printed.contains("after a job"), "{printed}");
    assert!(!printed.contains("inside a job"), "{printed}");
}
