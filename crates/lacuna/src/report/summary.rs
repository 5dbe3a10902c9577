//! Counts over the holes: the paper's table.

use super::kind::HoleKind;
use super::model::{HoleRecord, Outcome};
use super::round::micro;
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// Counts of one row: `found` = `filled` + `skipped` + `failed`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KindCount {
    /// Holes of this kind.
    pub found: u64,
    /// Of these, filled.
    pub filled: u64,
    /// Of these, left alone on purpose.
    pub skipped: u64,
    /// Of these, failed.
    pub failed: u64,
    /// Their area in plan.
    #[serde(with = "micro")]
    pub area_m2: f64,
}

/// One row for each [`HoleKind`], in their order; written as an object whose keys are [`HoleKind::key`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ByKind(pub [KindCount; 9]);

/// Counts over all holes of a report (one hole a cell, as the paper counts).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// All holes.
    pub found: u64,
    /// Of these, filled.
    pub filled: u64,
    /// Of these, left alone on purpose.
    pub skipped: u64,
    /// Of these, failed.
    pub failed: u64,
    /// The same by kind.
    pub by_type: ByKind,
}

impl Summary {
    /// Counts holes: the one place where these numbers are made, so that found = filled + skipped + failed in every
    /// row and in the total, whatever happened.
    #[must_use]
    pub fn from_holes(holes: &[HoleRecord]) -> Self {
        let mut by_type = ByKind::default();
        for hole in holes {
            by_type.0[hole.kind().row()].count(hole);
        }
        let sum = |part: fn(&KindCount) -> u64| by_type.0.iter().map(part).sum();
        Self {
            found: sum(|row| row.found),
            filled: sum(|row| row.filled),
            skipped: sum(|row| row.skipped),
            failed: sum(|row| row.failed),
            by_type,
        }
    }
}

impl KindCount {
    fn count(&mut self, hole: &HoleRecord) {
        self.found += 1;
        *match hole.outcome {
            Outcome::Filled => &mut self.filled,
            Outcome::Skipped => &mut self.skipped,
            Outcome::Failed => &mut self.failed,
        } += 1;
        self.area_m2 += hole.area_m2;
    }
}

impl ByKind {
    /// The row of a kind.
    #[must_use]
    pub fn get(&self, kind: HoleKind) -> &KindCount {
        &self.0[kind.row()]
    }
}

impl Serialize for ByKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for kind in HoleKind::ALL {
            map.serialize_entry(kind.key(), self.get(kind))?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for ByKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows = BTreeMap::<String, KindCount>::deserialize(deserializer)?;
        Ok(Self(HoleKind::ALL.map(|kind| rows.get(kind.key()).copied().unwrap_or_default())))
    }
}
