//! GLB tiles: dialects, frames, appending, hostile files, real files.

#![allow(clippy::print_stderr, reason = "a test that skips says so")]

mod appending;
mod new_tile;
mod random;
mod reading;
mod real;
mod refusals;
mod support;
