//! The text header of a PLY file: what it declares, and which of its bytes a rewrite may change.

use super::scalar::{Endian, Scalar};
use crate::error::Place;
use crate::fault::Fault;
use memchr::memchr;
use std::ops::Range;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    Binary(Endian),
}

/// One number a row, or a counted list of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, value: Scalar },
}

/// A column of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Line of the declaration, from 1.
    pub(crate) line: u64,
}

/// A table of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) count: u64,
    /// Bytes of the header that hold the count's digits.
    pub(crate) count_span: Range<usize>,
    pub(crate) properties: Vec<Property>,
    /// Line of the declaration, from 1.
    pub(crate) line: u64,
}

impl Element {
    /// Bytes of a binary row, `None` if rows hold lists.
    pub(crate) fn row_size(&self) -> Option<usize> {
        self.properties.iter().try_fold(0, |sum, property| match property.kind {
            Kind::Scalar(scalar) => Some(sum + scalar.size()),
            Kind::List { .. } => None,
        })
    }

    /// Fewest bytes that a row can have.
    pub(crate) fn least_row_size(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2, // a digit and what ends it
            (_, Kind::Scalar(scalar)) => scalar.size() as u64,
            (_, Kind::List { count, .. }) => count.size() as u64,
        };
        self.properties.iter().map(of).sum()
    }

    /// What is left of `left` bytes after all rows at their smallest; a fault if they do not hold them.
    pub(crate) fn left_after(&self, encoding: Encoding, left: u64) -> Result<u64, Fault> {
        let least = self.least_row_size(encoding);
        let slack = u64::from(encoding == Encoding::Ascii); // the last line may have no end
        let needed = self.count.checked_mul(least).filter(|needed| *needed <= left.saturating_add(slack));
        needed.map(|needed| left.saturating_sub(needed)).ok_or_else(|| {
            let problem = format!(
                "the header promises {} rows of `{}` of at least {least} bytes, {left} bytes are left",
                self.count,
                self.name.escape_debug()
            );
            Fault::malformed(Place::Line(self.line), problem)
        })
    }

    /// Index of the property of this name.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }

    /// Index of the list of vertex indices, in either spelling.
    pub(crate) fn find_indices(&self) -> Option<usize> {
        self.find("vertex_indices").or_else(|| self.find("vertex_index"))
    }
}

/// A parsed header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
    /// Offset of the line `end_header`.
    pub(crate) end_line: usize,
    /// Offset of the body's first byte.
    pub(crate) body: usize,
    /// How this header ends its lines.
    pub(crate) newline: &'static str,
    /// Names in `comment TextureFile` lines.
    pub(crate) textures: Vec<String>,
    /// Lines (with their ends) that speak of this file's own rows or textures: a new tile leaves them out.
    pub(crate) own_lines: Vec<Range<usize>>,
}

impl Header {
    /// Index of the element of this name.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.elements.iter().position(|e| e.name == name)
    }
}

/// Parses the header at the start of `bytes`; what follows it is not looked at.
pub(crate) fn parse_header(bytes: &[u8]) -> Result<Header, Fault> {
    let newline = match (bytes.starts_with(b"ply"), bytes.get(3), bytes.get(4)) {
        (true, Some(b'\r'), Some(b'\n')) => "\r\n",
        (true, Some(b'\r'), _) => {
            let advice = "convert the line ends to LF";
            return Err(Fault::unsupported(Place::Line(1), "header lines end in CR alone", advice));
        }
        (true, Some(b'\n' | b' ' | b'\t'), _) => "\n",
        _ => return Err(Fault::malformed(Place::Byte(0), "the file does not start with `ply`")),
    };
    let mut draft = Draft::default();
    let mut at = 0;
    for line in 1.. {
        let Some(length) = bytes.get(at..).and_then(|rest| memchr(b'\n', rest)) else {
            return Err(Fault::malformed(Place::Line(line), "the header has no `end_header` line"));
        };
        let text = Text { line, start: at, bytes: &bytes[at..at + length] };
        let next = at + length + 1;
        if draft.take(&text, next)? {
            return draft.finish(at, next, newline, line);
        }
        at = next;
    }
    Err(Fault::malformed(Place::File, "the header has no `end_header` line"))
}

/// A header line.
struct Text<'a> {
    line: u64,
    start: usize,
    bytes: &'a [u8],
}

impl Text<'_> {
    fn words(&self) -> Result<Vec<&str>, Fault> {
        let text = std::str::from_utf8(self.bytes);
        text.map(|t| t.split_ascii_whitespace().collect()).map_err(|_| self.fault("it is no text"))
    }

    fn fault(&self, problem: &str) -> Fault {
        Fault::malformed(Place::Line(self.line), format!("header: {problem}"))
    }
}

/// What the lines so far have said.
#[derive(Default)]
struct Draft {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    textures: Vec<String>,
    own_lines: Vec<Range<usize>>,
}

impl Draft {
    /// Takes one line; true if it was the last.
    fn take(&mut self, text: &Text<'_>, next: usize) -> Result<bool, Fault> {
        let keyword: &[u8] = text.bytes.split(u8::is_ascii_whitespace).find(|w| !w.is_empty()).unwrap_or(b"");
        match keyword {
            b"comment" => self.comment(text, next),
            b"obj_info" | b"ply" | b"" => {}
            b"format" => self.format(text)?,
            b"element" => self.element(text)?,
            b"property" => self.property(text)?,
            b"end_header" => return Ok(true),
            _ => return Err(text.fault("this keyword is not known")),
        }
        Ok(false)
    }

    /// Comments may hold any bytes.
    fn comment(&mut self, text: &Text<'_>, next: usize) {
        let line = String::from_utf8_lossy(text.bytes);
        let rest = line.trim().strip_prefix("comment").unwrap_or_default().trim();
        let texture = rest.strip_prefix("TextureFile").map(str::trim);
        self.textures.extend(texture.map(str::to_owned));
        if texture.is_some() || rest.starts_with("lacuna patch:") {
            self.own_lines.push(text.start..next);
        }
    }

    fn format(&mut self, text: &Text<'_>) -> Result<(), Fault> {
        let encoding = match text.words()?[..] {
            [_, "ascii", "1.0"] => Encoding::Ascii,
            [_, "binary_little_endian", "1.0"] => Encoding::Binary(Endian::Little),
            [_, "binary_big_endian", "1.0"] => Encoding::Binary(Endian::Big),
            _ => {
                return Err(
                    text.fault("the format must be ascii, binary_little_endian or binary_big_endian 1.0")
                );
            }
        };
        match self.encoding.replace(encoding) {
            None => Ok(()),
            Some(_) => Err(text.fault("there are two format lines")),
        }
    }

    fn element(&mut self, text: &Text<'_>) -> Result<(), Fault> {
        let words = text.words()?;
        let [_, name, digits] = words[..] else {
            return Err(text.fault("an element has a name and a count"));
        };
        let count = digits.parse().map_err(|_| text.fault("the count is no whole number below 2^64"))?;
        if self.elements.iter().any(|e| e.name == name) {
            return Err(text.fault("there are two elements of this name"));
        }
        let line = std::str::from_utf8(text.bytes).map_err(|_| text.fault("it is no text"))?;
        let start = text.start + line.trim_end().len() - digits.len();
        let count_span = start..start + digits.len();
        self.elements.push(Element {
            name: name.to_owned(),
            count,
            count_span,
            properties: Vec::new(),
            line: text.line,
        });
        Ok(())
    }

    fn property(&mut self, text: &Text<'_>) -> Result<(), Fault> {
        let scalar = |word: &str| {
            let place = Place::Line(text.line);
            let problem = format!("header: number type `{}`", word.escape_debug());
            let advice = "convert the tile to the number types of PLY 1.0";
            Scalar::from_name(word).ok_or_else(|| Fault::unsupported(place, problem, advice))
        };
        let (kind, name) = match text.words()?[..] {
            [_, "list", count, value, name] => {
                (Kind::List { count: scalar(count)?, value: scalar(value)? }, name)
            }
            [_, value, name] => (Kind::Scalar(scalar(value)?), name),
            _ => return Err(text.fault("a property has a type and a name")),
        };
        if matches!(kind, Kind::List { count, .. } if count.is_float()) {
            return Err(text.fault("a list's count must be of a whole number type"));
        }
        let element =
            self.elements.last_mut().ok_or_else(|| text.fault("a property stands before any element"))?;
        if element.find(name).is_some() {
            return Err(text.fault("the element has two properties of this name"));
        }
        element.properties.push(Property { name: name.to_owned(), kind, line: text.line });
        Ok(())
    }

    fn finish(self, end_line: usize, body: usize, newline: &'static str, line: u64) -> Result<Header, Fault> {
        let no_format = || Fault::malformed(Place::Line(line), "the header has no format line");
        Ok(Header {
            encoding: self.encoding.ok_or_else(no_format)?,
            elements: self.elements,
            end_line,
            body,
            newline,
            textures: self.textures,
            own_lines: self.own_lines,
        })
    }
}
