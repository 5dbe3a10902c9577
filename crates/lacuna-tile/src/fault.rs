//! A parser's finding before the file's name is known.

use crate::error::{Place, TileError};
use std::path::Path;

/// What a parser found wrong, and where. Parsers see bytes, not paths.
#[derive(Debug)]
pub(crate) struct Fault {
    place: Place,
    problem: String,
    advice: &'static str,
    is_unsupported: bool,
}

impl Fault {
    /// The file breaks its format.
    pub(crate) fn malformed(place: Place, problem: impl Into<String>) -> Self {
        let advice = "export the tile again or take it out of the scene";
        Self { place, problem: problem.into(), advice, is_unsupported: false }
    }

    /// The file may be right; this version can't handle it.
    pub(crate) fn unsupported(place: Place, problem: impl Into<String>, advice: &'static str) -> Self {
        Self { place, problem: problem.into(), advice, is_unsupported: true }
    }

    /// The public error, with the file's name.
    pub(crate) fn at(self, path: &Path) -> TileError {
        let Self { place, problem, advice, is_unsupported } = self;
        match is_unsupported {
            true => TileError::unsupported(path, place, problem, advice),
            false => TileError::malformed(path, place, problem, advice),
        }
    }
}

/// Room for `count` more values, or an error instead of an abort. Counts are compared with the file's bytes before.
pub(crate) fn reserve<T>(values: &mut Vec<T>, count: u64) -> Result<(), Fault> {
    usize::try_from(count).ok().and_then(|n| values.try_reserve_exact(n).ok()).ok_or_else(|| {
        let problem = format!("no memory for {count} values");
        Fault::unsupported(Place::File, problem, "free memory or cut the tile")
    })
}
