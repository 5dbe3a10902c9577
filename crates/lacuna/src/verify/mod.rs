//! Proves the promises on what a run wrote (product.md, "Promises"). Shares readers and predicates with the repair, and
//! nothing that decides: what is delivered, patched or open is found again from the files.

mod accounts;
mod again;
mod cell;
mod digest;
mod files;
mod holes_left;
mod islands;
mod layout;
mod originals;
mod overlap;
mod patch_mesh;
mod patch_plan;
mod patches;
mod plan_index;
mod ragged;
mod records;
mod run;
mod seams;
mod verdict;
mod work;

pub use digest::digest;
pub use run::{Again, VerifyOptions, verify};
pub use verdict::{PromiseResult, Status, Verdict};
