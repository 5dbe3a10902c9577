//! Jobs on a pool of threads, admitted as memory allows.

use crate::panics::catch_text;
use crate::{MemoryBudget, Reservation, StopFlag};
use rayon::{Scope, ThreadPool, ThreadPoolBuilder};
use std::cmp::Reverse;

/// Deep recursions (nested dissection, dynamic programming over a contour) need more than the platform's default.
const STACK_BYTES: usize = 8 << 20;

/// What the scheduler knows of a job; its place in the list is its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Order among jobs of equal size; such as the cell's number, so that it does not change with the listing order.
    pub key: u64,
    /// Memory that the job is lent while it runs, bytes.
    pub bytes: u64,
}

/// How a job ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JobResult<T> {
    /// It returned this.
    Done(T),
    /// It panicked with this message; our own bug, a record of that job alone.
    Panicked(String),
    /// It never started, because the stop flag was raised.
    Stopped,
}

/// A job needs more than the whole limit, or than what earlier jobs' results leave of it. No later job was started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "job {index} needs {needed_bytes} bytes, but the memory limit is {limit_bytes} bytes; raise --memory"
)]
pub struct TooSmall {
    /// Index of the job that needs most.
    pub index: usize,
    /// Bytes it needs: the smallest limit under which all jobs can run.
    pub needed_bytes: u64,
    /// Bytes of the whole budget but what is kept.
    pub limit_bytes: u64,
}

/// The threads could not be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot start {threads} threads: {reason}; ask for fewer with --threads")]
pub struct PoolError {
    /// Threads asked for.
    pub threads: usize,
    /// What the system says.
    pub reason: String,
}

/// Threads that run jobs; made once for a run.
#[derive(Debug)]
pub struct Pool {
    threads: ThreadPool,
}

impl Pool {
    /// Starts `threads` threads with stacks of 8 MiB; 0 means as many as the machine offers this process.
    ///
    /// # Errors
    /// [`PoolError`] if the system refuses to start them.
    pub fn new(threads: usize) -> Result<Self, PoolError> {
        let threads = if threads == 0 { machine_threads() } else { threads };
        let built = ThreadPoolBuilder::new()
            .num_threads(threads)
            .stack_size(STACK_BYTES)
            .thread_name(|index| format!("cells-{index}"))
            .build();
        match built {
            Ok(threads) => Ok(Self { threads }),
            Err(error) => Err(PoolError { threads, reason: error.to_string() }),
        }
    }

    /// Number of threads.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Runs all jobs and returns how each ended, by index; returns when the last one has ended.
    ///
    /// 1. A job above the whole budget is refused before anything starts.
    /// 2. Jobs are admitted biggest first (ties by key, then by index) by the calling thread, each as soon as its bytes
    ///    are free; no later job overtakes. The order is a function of `jobs` alone.
    /// 3. A worker calls `work(index)`; a panic in it ends that job only. Then the job's bytes go back.
    /// 4. `done(index)` is called on the worker for every job that returned or panicked, in the order of ending.
    /// 5. Once `stop` is raised no further job starts; those that run are finished.
    ///
    /// `work` must be sequential inside, and a pure function of the index if the output shall not depend on threads.
    /// The calling thread must not be a worker of this pool: it waits, and would wait for itself.
    ///
    /// # Errors
    /// [`TooSmall`], naming the job that needs most.
    ///
    /// # Panics
    /// A panic in `done` is the caller's own; it goes on here, after the other jobs have ended.
    pub fn run<T: Send>(
        &self,
        jobs: &[Job],
        budget: &MemoryBudget,
        stop: &StopFlag,
        work: impl Fn(usize) -> T + Sync,
        done: impl Fn(usize) + Sync,
    ) -> Result<Vec<JobResult<T>>, TooSmall> {
        debug_assert!(self.threads.current_thread_index().is_none(), "a worker must not schedule");
        check_sizes(jobs, budget)?;
        let mut results: Vec<JobResult<T>> = jobs.iter().map(|_| JobResult::Stopped).collect();
        let mut queue: Vec<(usize, &mut JobResult<T>)> = results.iter_mut().enumerate().collect();
        queue.sort_by_key(|(index, _)| admission_order(jobs, *index));
        let task = Task { stop, work: &work, done: &done };
        self.threads.in_place_scope(|scope| admit_all(scope, queue, jobs, budget, &task))?;
        Ok(results)
    }
}

/// What all jobs of one run share.
struct Task<'a, W, D> {
    stop: &'a StopFlag,
    work: &'a W,
    done: &'a D,
}

fn machine_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get)
}

fn admission_order(jobs: &[Job], index: usize) -> (Reverse<u64>, u64, usize) {
    (Reverse(jobs[index].bytes), jobs[index].key, index)
}

fn check_sizes(jobs: &[Job], budget: &MemoryBudget) -> Result<(), TooSmall> {
    let largest = (0..jobs.len()).min_by_key(|&index| admission_order(jobs, index));
    match largest {
        Some(index) if jobs[index].bytes > budget.total_bytes() => {
            Err(TooSmall { index, needed_bytes: jobs[index].bytes, limit_bytes: budget.total_bytes() })
        }
        _ => Ok(()),
    }
}

/// The scheduling loop, on the calling thread: memory first, then the job.
fn admit_all<'scope, T, W, D>(
    scope: &Scope<'scope>,
    queue: Vec<(usize, &'scope mut JobResult<T>)>,
    jobs: &[Job],
    budget: &MemoryBudget,
    task: &'scope Task<'_, W, D>,
) -> Result<(), TooSmall>
where
    T: Send,
    W: Fn(usize) -> T + Sync,
    D: Fn(usize) + Sync,
{
    for (index, slot) in queue {
        if task.stop.is_stopped() {
            break;
        }
        let reservation = budget.acquire(jobs[index].bytes).map_err(|over| TooSmall {
            index,
            needed_bytes: over.needed_bytes,
            limit_bytes: over.limit_bytes,
        })?;
        scope.spawn(move |_| run_one(index, slot, reservation, task));
    }
    Ok(())
}

/// One job on a worker.
fn run_one<T, W, D>(index: usize, slot: &mut JobResult<T>, reservation: Reservation, task: &Task<'_, W, D>)
where
    W: Fn(usize) -> T,
    D: Fn(usize),
{
    // Admitted jobs may have waited for a thread.
    if task.stop.is_stopped() {
        return;
    }
    *slot = match catch_text(|| (task.work)(index)) {
        Ok(value) => JobResult::Done(value),
        Err(message) => JobResult::Panicked(message),
    };
    drop(reservation);
    (task.done)(index);
}
