//! What the operating system and the allocator know about this process and its children: bytes in use, peaks, limits,
//! processor time.
//!
//! The only crate of the workspace that may hold `unsafe` code; every use says why it is sound. Sizes are bytes, times
//! are seconds. A figure that the platform does not give is `None`, never a guess: the figures are for the report and
//! for the default of `--memory`, and no output tile may depend on them.

mod allocator;
mod child;
mod limit;
mod process;

pub use allocator::{CountingAllocator, allocated_bytes, peak_allocated_bytes, reset_peak_allocated};
pub use child::{ChildUsage, ResidentMemory, TransferredBytes, WatchedChild, transferred_bytes};
pub use limit::available_memory_bytes;
pub use process::{cpu_seconds, current_rss_bytes, limit_arenas, peak_rss_bytes, reset_peak_rss, trim};
