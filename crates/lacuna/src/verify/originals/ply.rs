//! PLY: the header keeps its lines but counts, and each element's rows begin with the delivered ones.

use super::{Comparison, Mark};
use std::ops::Range;

/// Begins the comment that marks a patch.
const MARK: &str = "comment lacuna patch: ";

pub(super) fn compare(original: Option<&[u8]>, now: &[u8]) -> Comparison {
    let after = match Layout::parse(now) {
        Ok(layout) => layout,
        Err(problem) => return Comparison { problems: vec![problem], marks: Vec::new() },
    };
    let Some(original) = original else {
        return Comparison { problems: Vec::new(), marks: marks(&after.lines) };
    };
    let before = match Layout::parse(original) {
        Ok(layout) => layout,
        Err(problem) => {
            return Comparison { problems: vec![format!("as delivered: {problem}")], marks: Vec::new() };
        }
    };
    let mut problems = Vec::new();
    let added = match added_lines(&before.lines, &after.lines) {
        Ok(added) => added,
        Err(problem) => {
            problems.push(problem);
            Vec::new()
        }
    };
    compare_rows(original, &before, now, &after, &mut problems);
    Comparison { problems, marks: marks(&added) }
}

/// The lines of `after` that `before` lacks: only ours may be among them, and all of `before` must come in its order.
fn added_lines(before: &[String], after: &[String]) -> Result<Vec<String>, String> {
    let has_faces = before.iter().any(|line| line.starts_with("element face"));
    let is_ours = |line: &str| line.starts_with(MARK) || (!has_faces && is_plain_face_element(line));
    let mut added = Vec::new();
    let mut expected = before.iter().peekable();
    for line in after {
        if expected.next_if_eq(&line).is_some() {
            continue;
        }
        if !is_ours(line) {
            return Err(format!("header line {line:?} is not as delivered"));
        }
        added.push(line.clone());
    }
    match expected.next() {
        Some(line) => Err(format!("header line {line:?} is gone")),
        None => Ok(added),
    }
}

/// What a file without faces gets to hold the patch.
fn is_plain_face_element(line: &str) -> bool {
    line == "element face" || line == "property list uchar int vertex_indices"
}

fn compare_rows(original: &[u8], before: &Layout, now: &[u8], after: &Layout, problems: &mut Vec<String>) {
    for element in &before.elements {
        let name = &element.name;
        let Some(grown) = after.elements.iter().find(|e| e.name == *name) else {
            problems.push(format!("element {name} is gone"));
            continue;
        };
        let may_grow = name == "vertex" || name == "face";
        if grown.count < element.count || (grown.count > element.count && !may_grow) {
            problems
                .push(format!("element {name} has {} rows, {} were delivered", grown.count, element.count));
        }
        let (old, new) = (&original[element.span.clone()], &now[grown.span.clone()]);
        if !new.starts_with(old) {
            let byte = old.iter().zip(new).take_while(|(a, b)| a == b).count();
            problems.push(format!("rows of element {name} are not as delivered, from their byte {byte} on"));
        }
    }
    let tail = |bytes: &[u8], layout: &Layout| bytes[layout.end..].to_vec();
    if tail(original, before) != tail(now, after) {
        problems.push("the bytes after the last row are not as delivered".to_owned());
    }
}

/// `comment lacuna patch: vertices A..B faces C..D hole ID`.
fn marks(lines: &[String]) -> Vec<Mark> {
    let mark = |line: &String| {
        let rest = line.strip_prefix(MARK)?;
        let (ranges, hole) = rest.split_once(" hole ")?;
        let faces = ranges.split_once(" faces ")?.1;
        Some(Mark { hole: hole.to_owned(), triangles: count_of(faces)? })
    };
    lines.iter().filter_map(mark).collect()
}

/// Numbers in `first..last` (both included) or `none`.
fn count_of(range: &str) -> Option<u64> {
    if range == "none" {
        return Some(0);
    }
    let (first, last) = range.split_once("..")?;
    let (first, last): (u64, u64) = (first.parse().ok()?, last.parse().ok()?);
    Some((last + 1).saturating_sub(first))
}

/// How a property is stored.
enum Property {
    Scalar(usize),
    /// Sizes of the count and of an item; whether the count is a float is not allowed for.
    List(usize, usize),
}

/// A table of the body.
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
    span: Range<usize>,
}

/// A header and where the rows of each element lie.
struct Layout {
    /// Header lines without the counts of elements.
    lines: Vec<String>,
    elements: Vec<Element>,
    end: usize,
}

impl Layout {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let mut layout = Self { lines: Vec::new(), elements: Vec::new(), end: 0 };
        let mut encoding = Encoding::Ascii;
        loop {
            let rest = &bytes[layout.end..];
            let Some(length) = rest.iter().position(|b| *b == b'\n') else {
                return Err("the header has no end".to_owned());
            };
            let line = String::from_utf8_lossy(&rest[..length]).trim_end().to_owned();
            layout.end += length + 1;
            if line == "end_header" {
                break;
            }
            layout.take_line(&line, &mut encoding)?;
        }
        layout.find_rows(bytes, encoding)?;
        Ok(layout)
    }

    fn take_line(&mut self, line: &str, encoding: &mut Encoding) -> Result<(), String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut kept = line.to_owned();
        match words.as_slice() {
            ["format", "ascii", ..] => *encoding = Encoding::Ascii,
            ["format", "binary_big_endian", ..] => *encoding = Encoding::Big,
            ["format", ..] => *encoding = Encoding::Little,
            ["element", name, count] => {
                let count = count.parse().map_err(|_| format!("line {line:?} has no count"))?;
                kept = format!("element {name}");
                self.elements.push(Element {
                    name: (*name).to_owned(),
                    count,
                    properties: Vec::new(),
                    span: 0..0,
                });
            }
            ["property", "list", count, item, _] => self.add(Property::List(size_of(count)?, size_of(item)?)),
            ["property", kind, _] => self.add(Property::Scalar(size_of(kind)?)),
            _ => {}
        }
        self.lines.push(kept);
        Ok(())
    }

    fn add(&mut self, property: Property) {
        if let Some(element) = self.elements.last_mut() {
            element.properties.push(property);
        }
    }

    fn find_rows(&mut self, bytes: &[u8], encoding: Encoding) -> Result<(), String> {
        for element in &mut self.elements {
            let start = self.end;
            let end = match encoding {
                Encoding::Ascii => end_of_lines(bytes, start, element),
                _ => end_of_rows(bytes, start, element, encoding),
            };
            self.end = end.ok_or_else(|| format!("the rows of element {} end early", element.name))?;
            element.span = start..self.end;
        }
        Ok(())
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

fn size_of(kind: &str) -> Result<usize, String> {
    Ok(match kind {
        "char" | "uchar" | "int8" | "uint8" => 1,
        "short" | "ushort" | "int16" | "uint16" => 2,
        "int" | "uint" | "float" | "int32" | "uint32" | "float32" => 4,
        "double" | "float64" => 8,
        _ => return Err(format!("type {kind:?} is unknown")),
    })
}

fn end_of_rows(bytes: &[u8], start: usize, element: &Element, encoding: Encoding) -> Option<usize> {
    let fixed: Option<usize> = element.properties.iter().try_fold(0, |sum, property| match property {
        Property::Scalar(size) => Some(sum + size),
        Property::List(..) => None,
    });
    let mut at = start;
    if let Some(row) = fixed {
        at = start.checked_add(row.checked_mul(usize::try_from(element.count).ok()?)?)?;
    } else {
        for _ in 0..element.count {
            for property in &element.properties {
                at += match *property {
                    Property::Scalar(size) => size,
                    Property::List(count, item) => {
                        count + item.checked_mul(number(bytes.get(at..at + count)?, encoding))?
                    }
                };
            }
            if at > bytes.len() {
                return None;
            }
        }
    }
    (at <= bytes.len()).then_some(at)
}

/// A whole number of 1 to 8 bytes.
fn number(bytes: &[u8], encoding: Encoding) -> usize {
    let join = |sum: usize, byte: &u8| (sum << 8) | usize::from(*byte);
    match encoding {
        Encoding::Big => bytes.iter().fold(0, join),
        _ => bytes.iter().rev().fold(0, join),
    }
}

/// The end of the line that holds the last number of the element's rows; numbers may be spread over lines.
fn end_of_lines(bytes: &[u8], start: usize, element: &Element) -> Option<usize> {
    let mut at = start;
    for _ in 0..element.count {
        for property in &element.properties {
            let word = next_word(bytes, &mut at)?;
            if let Property::List(..) = property {
                let count: usize = std::str::from_utf8(word).ok()?.parse().ok()?;
                for _ in 0..count {
                    next_word(bytes, &mut at)?;
                }
            }
        }
    }
    if element.count == 0 {
        return Some(start);
    }
    Some(bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |length| at + length + 1))
}

fn next_word<'a>(bytes: &'a [u8], at: &mut usize) -> Option<&'a [u8]> {
    let first = *at + bytes[*at..].iter().position(|b| !b.is_ascii_whitespace())?;
    let length = bytes[first..].iter().position(u8::is_ascii_whitespace).unwrap_or(bytes.len() - first);
    *at = first + length;
    Some(&bytes[first..*at])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ascii(comments: &str, vertices: &[&str], faces: &[&str]) -> String {
        format!(
            "ply\nformat ascii 1.0\ncomment made by hand\n{0}element vertex {1}\nproperty float x\nproperty float y\n\
             property float z\nelement face {2}\nproperty list uchar int vertex_indices\n{3}end_header\n{4}{5}",
            comments,
            vertices.len(),
            faces.len(),
            "",
            vertices.concat(),
            faces.concat()
        )
    }

    #[test]
    fn rows_and_lines_lead() {
        let (v, f) = (["0 0 0\n", "1 0 0\n", "1 1 0\n"], ["3 0 1 2\n"]);
        let delivered = ascii("", &v, &f);
        let mark = "comment lacuna patch: vertices 3..3 faces 1..2 hole 5_6/Tile\n";
        let more = [&f[..], &["3 1 2 3\n", "3 2 3 0\n"]].concat();
        let grown = [&v[..], &["2 2 2\n"]].concat();
        let other_vertex = ["0 0 0\n", "1 0 5\n", "1 1 0\n", "2 2 2\n"];
        let cases = [
            ("grown", ascii(mark, &grown, &more), 0),
            ("the same", delivered.clone(), 0),
            ("moved", ascii(mark, &other_vertex, &more), 1),
            ("a face left out", ascii(mark, &grown, &more[1..]), 1),
            ("a strange comment", ascii("comment hello\n", &v, &f), 1),
            ("a comment gone", delivered.replace("comment made by hand\n", ""), 1),
            ("another type", delivered.replace("float z", "double z"), 1),
            ("cut off", delivered[..delivered.len() - 9].to_owned(), 1),
            ("a tail", format!("{delivered}tail"), 1),
        ];
        for (name, now, problems) in cases {
            let found = compare(Some(delivered.as_bytes()), now.as_bytes());
            assert_eq!(found.problems.len(), problems, "{name}: {:?}", found.problems);
        }
        let found = compare(Some(delivered.as_bytes()), ascii(mark, &grown, &more).as_bytes());
        assert_eq!(found.marks, [Mark { hole: "5_6/Tile".to_owned(), triangles: 2 }]);
        assert!(
            compare(Some(ascii(mark, &v, &f).as_bytes()), ascii(mark, &v, &f).as_bytes()).marks.is_empty()
        );
    }

    #[test]
    fn binary_rows_are_found() {
        for (format, item) in [("binary_little_endian", [2, 0]), ("binary_big_endian", [0, 2])] {
            let header = |n: u32| {
                format!(
                    "ply\nformat {format} 1.0\nelement face {n}\nproperty list ushort uchar vertex_indices\n\
                     element extra 1\nproperty short a\nend_header\n"
                )
            };
            let row = |a, b| [item[0], item[1], a, b];
            let before = [header(1).as_bytes(), &row(7, 8), &[1, 2]].concat();
            let after = [header(2).as_bytes(), &row(7, 8), &row(9, 9), &[1, 2]].concat();
            let lost = [header(2).as_bytes(), &row(7, 9), &row(9, 9), &[1, 2]].concat();
            let extra = [header(2).as_bytes(), &row(7, 8), &row(9, 9), &[1, 3]].concat();
            assert_eq!(compare(Some(&before), &after).problems, Vec::<String>::new());
            assert_eq!(compare(Some(&before), &lost).problems.len(), 1);
            assert_eq!(compare(Some(&before), &extra).problems.len(), 1);
        }
    }
}
