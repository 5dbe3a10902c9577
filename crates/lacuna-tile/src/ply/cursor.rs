//! Walks the body of a PLY file row by row, in any encoding.

use super::header::{Element, Encoding, Kind};
use super::scalar::{Endian, Scalar};
use crate::error::Place;
use crate::fault::Fault;
use memchr::{memchr, memchr_iter};

/// A place in the body from which values are read in order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    extra_tokens: u64,
}

impl<'a> Cursor<'a> {
    /// Starts at offset `at` of the file's `bytes`.
    pub(crate) fn new(bytes: &'a [u8], at: usize, encoding: Encoding) -> Self {
        Self { bytes, at, encoding, extra_tokens: 0 }
    }

    /// Offset of the next unread byte.
    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// How the body is written.
    pub(crate) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Moves to another offset.
    pub(crate) fn seek(&mut self, at: usize) {
        self.at = at;
    }

    /// Text rows that held more values than declared; the surplus was passed over.
    pub(crate) fn extra_tokens(&self) -> u64 {
        self.extra_tokens
    }

    /// The unread bytes.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Fails unless the bytes left can hold all rows of `element` at their smallest: before any allocation by its count.
    pub(crate) fn check_count(&self, element: &Element) -> Result<(), Fault> {
        element.left_after(self.encoding, self.rest().len() as u64).map(|_| ())
    }

    /// Passes over all rows of an element.
    pub(crate) fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        self.check_count(element)?;
        if element.properties.is_empty() {
            return Ok(());
        }
        if let (Encoding::Binary(_), Some(size)) = (self.encoding, element.row_size()) {
            self.at += size * element.count as usize; // fits: check_count compared it with the bytes left
            return Ok(());
        }
        (0..element.count).try_for_each(|_| self.skip_row(element))
    }

    /// Passes over one row.
    pub(crate) fn skip_row(&mut self, element: &Element) -> Result<(), Fault> {
        self.begin_row();
        for property in &element.properties {
            self.skip_value(property.kind)?;
        }
        self.end_row();
        Ok(())
    }

    /// Passes over one property of a row.
    pub(crate) fn skip_value(&mut self, kind: Kind) -> Result<(), Fault> {
        match (kind, self.encoding) {
            (Kind::Scalar(scalar), Encoding::Binary(_)) => self.take(scalar.size()).map(drop),
            (Kind::Scalar(_), Encoding::Ascii) => self.token().map(drop),
            (Kind::List { count, value }, _) => {
                let length = self.list_length(count, value)?;
                match self.encoding {
                    Encoding::Binary(_) => self.take(length * value.size()).map(drop),
                    Encoding::Ascii => (0..length).try_for_each(|_| self.token().map(drop)),
                }
            }
        }
    }

    /// Must be called before a row's first value: text rows start at the next line that isn't blank.
    pub(crate) fn begin_row(&mut self) {
        if self.encoding == Encoding::Ascii {
            let blank = self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
            self.at += blank;
        }
    }

    /// Must be called after a row's last value: text rows end with their line.
    pub(crate) fn end_row(&mut self) {
        if self.encoding == Encoding::Ascii {
            let rest = self.rest();
            let length = memchr(b'\n', rest).map_or(rest.len(), |n| n + 1);
            self.extra_tokens += u64::from(!rest[..length].trim_ascii().is_empty());
            self.at += length;
        }
    }

    /// One value.
    pub(crate) fn scalar(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        match self.encoding {
            Encoding::Binary(endian) => self.binary(scalar, endian),
            Encoding::Ascii => {
                let token = self.token()?;
                scalar.parse(token).ok_or_else(|| {
                    let text =
                        String::from_utf8_lossy(&token[..token.len().min(40)]).escape_debug().to_string();
                    self.fault(format!("`{text}` is no number"))
                })
            }
        }
    }

    /// The length of a list whose values must all lie in the file.
    pub(crate) fn list_length(&mut self, count: Scalar, value: Scalar) -> Result<usize, Fault> {
        let length = self.scalar(count)?;
        let least = if self.encoding == Encoding::Ascii { 2 } else { value.size() };
        let most = self.rest().len() / least;
        if length >= 0.0 && length.fract() == 0.0 && length <= most as f64 {
            return Ok(length as usize);
        }
        Err(self.fault(format!("a list of {length} values, at most {most} are left in the file")))
    }

    /// A fault at this place: a line of text, a byte of a binary body.
    pub(crate) fn fault(&self, problem: String) -> Fault {
        let place = match self.encoding {
            Encoding::Ascii => {
                let before = &self.bytes[..self.at.min(self.bytes.len())];
                Place::Line(memchr_iter(b'\n', before).count() as u64 + 1)
            }
            Encoding::Binary(_) => Place::Byte(self.at as u64),
        };
        Fault::malformed(place, problem)
    }

    fn binary(&mut self, scalar: Scalar, endian: Endian) -> Result<f64, Fault> {
        self.take(scalar.size()).map(|bytes| scalar.decode(bytes, endian))
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let taken =
            self.rest().get(..count).ok_or_else(|| self.fault("the file ends inside a row".to_owned()))?;
        self.at += count;
        Ok(taken)
    }

    /// The next word of the same line.
    fn token(&mut self) -> Result<&'a [u8], Fault> {
        let rest = self.rest();
        let start = rest.iter().position(|b| !matches!(b, b' ' | b'\t' | b'\r')).unwrap_or(rest.len());
        let word = &rest[start..];
        let length = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        if length == 0 {
            return Err(self.fault("the row has too few values".to_owned()));
        }
        self.at += start + length;
        Ok(&word[..length])
    }
}
