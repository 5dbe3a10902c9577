//! Tile names: which cell a file name speaks of, and the name of a tile that does not exist yet.

use std::fmt::Write as _;

/// What a tile's file stem says about its cell.
///
/// Two families are known. *Signed* pairs (`Tile_+012_-003_L17`) are iTwin Capture's: each number carries its sign and
/// the pair is the cell's column (east) and row (north). *Unsigned* pairs (`cell_00_01`) are everybody's: they may be a
/// date or a part number as well, so a caller has to check them against the tiles' boxes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileName {
    /// Text before the pair, without the underscore that joins them.
    pub prefix: String,
    /// Column (east) and row (north).
    pub index: (i32, i32),
    /// Third signed number of a volumetric tiling. There is no flat grid then.
    pub z: Option<i32>,
    /// Text after the numbers, as written: `_L17`, `_L19_0uuuu3`. `None` if the stem ends with the numbers.
    pub tail: Option<String>,
    /// True if both numbers carry a sign.
    pub signed: bool,
    /// Digits of column and row as written, for zero padding.
    digits: (usize, usize),
}

/// One number of a name: value, digits written, bytes taken, sign written.
struct Number {
    value: i32,
    digits: usize,
    bytes: usize,
    signed: bool,
}

impl TileName {
    /// Reads a file stem (the name without folder and extension); `None` if it holds no pair.
    ///
    /// 1. The leftmost `_[+-]digits_[+-]digits` behind a non-empty prefix is a signed pair; a further `_[+-]digits` is z.
    /// 2. Else the rightmost `_digits_digits` (a minus is allowed) is an unsigned pair, if nothing but a level tail
    ///    (`_L17...`) follows.
    ///
    /// Numbers that do not fit an `i32` are no pair.
    #[must_use]
    pub fn parse(stem: &str) -> Option<Self> {
        let joints = || stem.match_indices('_').map(|(at, _)| at).filter(|&at| at > 0);
        joints()
            .find_map(|at| signed_pair_at(stem, at))
            .or_else(|| joints().rev().find_map(|at| unsigned_pair_at(stem, at)))
    }

    /// The level of detail that the tail names (`_L17...` gives 17).
    #[must_use]
    pub fn level(&self) -> Option<u32> {
        Some(split_level(self.tail.as_deref()?)?.0)
    }

    /// The place in the level-of-detail tree that the tail names (`_L19_0uuuu3` gives `0uuuu3`).
    ///
    /// Only digits and `u` count as such a place; any other tail gives `None`.
    #[must_use]
    pub fn node(&self) -> Option<&str> {
        let node = split_level(self.tail.as_deref()?)?.1.strip_prefix('_')?;
        let is_node = !node.is_empty() && node.bytes().all(|b| b.is_ascii_digit() || b == b'u');
        is_node.then_some(node)
    }

    /// The stem without its tail: the cell's own name, which messages and reports use.
    #[must_use]
    pub fn cell_name(&self) -> String {
        let mut name = format_like(&Self { tail: None, ..self.clone() }, self.index);
        if let Some(z) = self.z {
            // Writing to a String cannot fail.
            let _ = write!(name, "_{z:+04}");
        }
        name
    }
}

/// The stem of the tile at `index` in the manner of `template`: same prefix, sign style, zero padding and tail.
///
/// A negative number in an unsigned template gets its minus in front of the padding (`cell_-01_00`); two of them read back
/// as a signed pair.
#[must_use]
pub fn format_like(template: &TileName, index: (i32, i32)) -> String {
    let (x, y) = (template.digits.0, template.digits.1);
    let pair =
        format!("{}_{}", number_like(index.0, x, template.signed), number_like(index.1, y, template.signed));
    format!("{}_{pair}{}", template.prefix, template.tail.as_deref().unwrap_or(""))
}

/// True for the name of an adaptive tiling: one signed number alone (`Tile_+012`), which is no place in a grid.
pub(crate) fn is_adaptive(stem: &str) -> bool {
    if TileName::parse(stem).is_some() {
        return false;
    }
    let behind = |(at, _): (usize, &str)| &stem[at + 1..];
    let mut signed =
        stem.match_indices('_').map(behind).filter(|rest| number_at(rest).is_some_and(|n| n.signed));
    let (Some(rest), None) = (signed.next(), signed.next()) else { return false };
    let tail = rest[1..].trim_start_matches(|c: char| c.is_ascii_digit());
    rest.len() < stem.len() - 1 && (tail.is_empty() || split_level(tail).is_some())
}

fn number_like(value: i32, digits: usize, signed: bool) -> String {
    let sign = match (value < 0, signed) {
        (true, _) => "-",
        (false, true) => "+",
        (false, false) => "",
    };
    format!("{sign}{:0digits$}", value.unsigned_abs())
}

/// The signed pair that begins with the underscore at byte `at`.
fn signed_pair_at(stem: &str, at: usize) -> Option<TileName> {
    let (x, rest) = next_number(&stem[at..])?;
    let (y, rest) = next_number(rest)?;
    if !(x.signed && y.signed) {
        return None;
    }
    let third = next_number(rest).filter(|(z, _)| z.signed);
    let tail = third.as_ref().map_or(rest, |(_, after)| after);
    let name = name_of(&stem[..at], &x, &y, tail, true);
    Some(TileName { z: third.map(|(z, _)| z.value), ..name })
}

/// The unsigned pair that begins with the underscore at byte `at` and ends the stem, but for a level tail.
fn unsigned_pair_at(stem: &str, at: usize) -> Option<TileName> {
    let (x, rest) = next_number(&stem[at..])?;
    let (y, rest) = next_number(rest)?;
    let ends = rest.is_empty() || split_level(rest).is_some();
    let plain = |n: &Number| !n.signed || n.value < 0;
    (ends && plain(&x) && plain(&y)).then(|| name_of(&stem[..at], &x, &y, rest, false))
}

fn name_of(prefix: &str, x: &Number, y: &Number, tail: &str, signed: bool) -> TileName {
    TileName {
        prefix: prefix.to_owned(),
        index: (x.value, y.value),
        z: None,
        tail: (!tail.is_empty()).then(|| tail.to_owned()),
        signed,
        digits: (x.digits, y.digits),
    }
}

/// Splits `_` and a number off the front of `text`.
fn next_number(text: &str) -> Option<(Number, &str)> {
    let rest = text.strip_prefix('_')?;
    let number = number_at(rest)?;
    let after = &rest[number.bytes..];
    Some((number, after))
}

/// The number at the front of `text`: an optional sign and ASCII digits.
fn number_at(text: &str) -> Option<Number> {
    let signed = text.starts_with(['+', '-']);
    let start = usize::from(signed);
    let digits = text[start..].bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 {
        return None;
    }
    let bytes = start + digits;
    let value = text[..bytes].parse().ok()?;
    Some(Number { value, digits, bytes, signed })
}

/// Splits a tail `_L17_0uuu` into its level and what follows the level's digits.
fn split_level(tail: &str) -> Option<(u32, &str)> {
    let rest = tail.strip_prefix("_L")?;
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let after = &rest[digits..];
    let level = rest[..digits].parse().ok()?;
    (after.is_empty() || after.starts_with('_')).then_some((level, after))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(stem: &str) -> String {
        TileName::parse(stem).map_or_else(
            || if is_adaptive(stem) { "adaptive".into() } else { "none".into() },
            |n| {
                let sign = if n.signed { "signed" } else { "plain" };
                let z = n.z.map_or(String::new(), |z| format!(" z{z}"));
                format!("{} {:?}{z} {:?} {sign}", n.prefix, n.index, n.tail.unwrap_or_default())
            },
        )
    }

    #[test]
    fn stems_parse_as_listed() {
        let cases = [
            ("Tile_+012_-003", r#"Tile (12, -3) "" signed"#),
            ("Tile_+000_+013_L17", r#"Tile (0, 13) "_L17" signed"#),
            ("Tile_+000_+013_L19_0uuuu3", r#"Tile (0, 13) "_L19_0uuuu3" signed"#),
            ("Block A_+1_+2", r#"Block A (1, 2) "" signed"#),
            ("my_old_tile_-0001_+0002", r#"my_old_tile (-1, 2) "" signed"#),
            ("Tile_+000_+001_+002", r#"Tile (0, 1) z2 "" signed"#),
            ("Tile_+000_+001_+002_L20_00", r#"Tile (0, 1) z2 "_L20_00" signed"#),
            ("Tile_+000_+001_2", r#"Tile (0, 1) "_2" signed"#),
            ("cell_00_01", r#"cell (0, 1) "" plain"#),
            ("cell_-01_03", r#"cell (-1, 3) "" plain"#),
            ("cell_0_1_L17_0uu", r#"cell (0, 1) "_L17_0uu" plain"#),
            ("scan_2024_05_01", r#"scan_2024 (5, 1) "" plain"#),
            ("cell_0_1_copy", "none"),
            ("cell_+0_1", "none"),
            ("_+000_+001", "none"),
            ("Tile_+99999999999_+0", "adaptive"),
            ("Tile_+012", "adaptive"),
            ("Tile_+012_L17_0", "adaptive"),
            ("Block", "none"),
            ("", "none"),
            ("_", "none"),
            ("é_+1_+2é", r#"é (1, 2) "é" signed"#),
        ];
        for (stem, expected) in cases {
            assert_eq!(summary(stem), expected, "stem {stem:?}");
        }
    }

    #[test]
    fn level_and_node_come_from_the_tail() {
        let cases = [
            ("T_+0_+0_L17", Some(17), None),
            ("T_+0_+0_L19_0uuuu3", Some(19), Some("0uuuu3")),
            ("T_+0_+0_L21_0000320", Some(21), Some("0000320")),
            ("T_+0_+0_L21_mesh", Some(21), None),
            ("T_+0_+0_Lx", None, None),
            ("T_+0_+0", None, None),
        ];
        for (stem, level, node) in cases {
            let name = TileName::parse(stem).expect(stem);
            assert_eq!((name.level(), name.node()), (level, node), "stem {stem}");
            assert_eq!(name.cell_name(), "T_+0_+0");
        }
    }

    #[test]
    fn format_like_keeps_the_manner() {
        let cases = [
            ("Tile_+012_-003", (1, -20), "Tile_+001_-020"),
            ("Tile_+012_-003_L17", (-1, 1234), "Tile_-001_+1234_L17"),
            ("cell_00_01", (3, 10), "cell_03_10"),
            ("cell_00_01", (-3, 0), "cell_-03_00"),
            ("c_0_1", (10, -10), "c_10_-10"),
            ("t_+0_+0", (i32::MIN, i32::MAX), "t_-2147483648_+2147483647"),
        ];
        for (stem, index, expected) in cases {
            let template = TileName::parse(stem).expect(stem);
            let made = format_like(&template, index);
            assert_eq!(made, expected);
            assert_eq!(TileName::parse(&made).map(|n| n.index), Some(index), "{made} reads back");
        }
    }

    #[test]
    fn format_like_of_its_own_index_is_the_stem() {
        for stem in ["Tile_+000_+013_L19_0uuuu3", "cell_00_01", "a b_-1_+2", "x_-01_00"] {
            let name = TileName::parse(stem).expect(stem);
            assert_eq!(format_like(&name, name.index), stem);
        }
    }
}
