//! What `verify` says: one result a promise, and the table for the terminal.

use std::collections::BTreeMap;
use std::fmt::Write;

/// Width of the table.
const COLUMNS: usize = 80;
/// Offenders that are named; further ones are only counted.
const NAMED_OFFENDERS: usize = 10;

/// How a promise stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Everything that could be judged is as promised.
    Held,
    /// At least one place is not.
    Broken,
    /// There was nothing to judge it by.
    NotJudged,
}

impl Status {
    /// The word in the table.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Broken => "BROKEN",
            Self::NotJudged => "not judged",
        }
    }
}

/// The result for one promise (product.md, "Promises").
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PromiseResult {
    /// Number of the promise, 1 to 8.
    pub number: u8,
    /// The promise in a few words.
    pub title: &'static str,
    /// How it stands.
    pub status: Status,
    /// The first offenders, one line each: tile, place, what is wrong.
    pub details: Vec<String>,
    /// All offenders, those that are not named included.
    pub offenders: u64,
    /// What was looked at, by name.
    pub counts: BTreeMap<&'static str, u64>,
    /// What the reader should know, without being an offence.
    pub notes: Vec<String>,
}

/// The results for all promises that `verify` looks at, by number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// One a promise, ascending.
    pub promises: Vec<PromiseResult>,
}

impl Verdict {
    /// True if no promise is broken: the process may end with 0.
    #[must_use]
    pub fn is_ok(&self) -> bool {
        self.promises.iter().all(|p| p.status != Status::Broken)
    }

    /// The result for a promise, by its number.
    #[must_use]
    pub fn promise(&self, number: u8) -> Option<&PromiseResult> {
        self.promises.iter().find(|p| p.number == number)
    }

    /// The table: a line a promise with what was looked at, then the offenders; 80 columns.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for promise in &self.promises {
            promise.write(&mut text);
        }
        let broken = self.promises.iter().filter(|p| p.status == Status::Broken).count();
        let end = match broken {
            0 => "No promise is broken.\n".to_owned(),
            1 => "1 promise is broken.\n".to_owned(),
            n => format!("{n} promises are broken.\n"),
        };
        text + &end
    }
}

impl PromiseResult {
    fn write(&self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {:<66} {:>11}", self.number, self.title, self.status.word());
        let looked: Vec<String> = self.counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
        if !looked.is_empty() {
            wrapped(text, &looked.join(", "), "    ", "    ");
        }
        self.notes.iter().for_each(|note| wrapped(text, note, "    ", "    "));
        self.details.iter().for_each(|detail| wrapped(text, detail, "  - ", "    "));
        let unnamed = self.offenders.saturating_sub(self.details.len() as u64);
        if unnamed > 0 {
            wrapped(text, &format!("and {unnamed} more"), "  - ", "    ");
        }
    }
}

/// Writes words into lines of at most 80 columns; a longer word has a line of its own.
fn wrapped(text: &mut String, words: &str, first: &str, next: &str) {
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in words.split_whitespace() {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            text.push_str(line.trim_end());
            text.push('\n');
            line = next.to_owned();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

/// Collects what the checks of one promise find.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Findings {
    offenders: u64,
    details: Vec<String>,
    counts: BTreeMap<&'static str, u64>,
    notes: Vec<String>,
}

impl Findings {
    /// Something is not as promised.
    pub(super) fn offend(&mut self, what: impl Into<String>) {
        self.offenders += 1;
        if self.details.len() < NAMED_OFFENDERS {
            // Names come from files: nothing in them may move the cursor.
            self.details.push(what.into().chars().map(|c| if c.is_control() { '?' } else { c }).collect());
        }
    }

    /// Looked at so many more of these.
    pub(super) fn count(&mut self, name: &'static str, number: u64) {
        *self.counts.entry(name).or_default() += number;
    }

    /// Something to know.
    pub(super) fn note(&mut self, what: impl Into<String>) {
        self.notes.push(what.into());
    }

    /// Takes over what another part of the check found.
    pub(super) fn take(&mut self, other: Self) {
        self.offenders += other.offenders;
        let room = NAMED_OFFENDERS - self.details.len();
        self.details.extend(other.details.into_iter().take(room));
        other.counts.into_iter().for_each(|(name, number)| self.count(name, number));
        self.notes.extend(other.notes);
    }

    /// How many of these were looked at.
    pub(super) fn counted(&self, name: &str) -> u64 {
        self.counts.get(name).copied().unwrap_or(0)
    }

    /// The result; without offenders it is held if anything was judged.
    pub(super) fn into_result(self, number: u8, title: &'static str, is_judged: bool) -> PromiseResult {
        let status = match (self.offenders, is_judged) {
            (0, true) => Status::Held,
            (0, false) => Status::NotJudged,
            _ => Status::Broken,
        };
        let Self { offenders, details, counts, notes } = self;
        PromiseResult { number, title, status, details, offenders, counts, notes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_keeps_to_80_columns_and_names_ten_offenders() {
        let mut findings = Findings::default();
        (0..14).for_each(|k| findings.offend(format!("Tile_{k}: {}", "a word and another ".repeat(9))));
        findings.count("tiles", 3);
        let promises = vec![findings.into_result(2, "originals byte for byte", true)];
        let text = Verdict { promises }.to_text();
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        assert!(text.contains("BROKEN") && text.contains("Tile_9") && !text.contains("Tile_10"));
        assert!(text.contains("and 4 more") && text.ends_with("1 promise is broken.\n"));
    }

    #[test]
    fn without_anything_to_judge_a_promise_is_not_judged() {
        for (judged, offenders, expected) in
            [(false, 0, Status::NotJudged), (true, 0, Status::Held), (false, 1, Status::Broken)]
        {
            let mut findings = Findings::default();
            (0..offenders).for_each(|_| findings.offend("x\u{1b}[2J"));
            let result = findings.into_result(4, "seams", judged);
            assert_eq!(result.status, expected);
            assert!(result.details.iter().all(|d| !d.contains('\u{1b}')));
        }
    }
}
