//! Cell jobs in parallel under one memory limit.
//!
//! The crate knows no meshes and no cells: a job is a number of bytes and a place in a list. Memory is lent before a
//! job starts, on the thread that schedules, and comes back by `Drop`; so the sum of what running jobs were lent never
//! exceeds the limit, and no worker ever waits for memory while it holds some. A barrier between stages or layers is
//! one [`Pool::run`] after the other.

mod budget;
mod panics;
mod pool;
mod stop;

pub use budget::{MemoryBudget, OverLimit, Reservation};
pub use pool::{Job, JobResult, Pool, PoolError, TooSmall};
pub use stop::StopFlag;
