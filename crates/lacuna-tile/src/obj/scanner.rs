//! Walks the statements of an OBJ file, number by number.

use crate::error::Place;
use crate::fault::Fault;
use memchr::{memchr, memchr_iter};

/// A place in an OBJ file. All line ends, blanks and `\` continuations are dealt with here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Numbers with something unreadable stuck to their end (`3.1+e2`): the number counts, the rest is passed over.
    pub(crate) odd_numbers: u64,
}

impl<'a> Scanner<'a> {
    /// Starts at offset `at`.
    pub(crate) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, odd_numbers: 0 }
    }

    /// Offset of the next unread byte.
    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// Moves to the next statement and returns its first two bytes (a missing one reads as a line end); `None` at the
    /// file's end. The scanner then stands on the first byte.
    #[inline]
    pub(crate) fn next_statement(&mut self) -> Option<[u8; 2]> {
        loop {
            let first = *self.bytes.get(self.at)?;
            if !first.is_ascii_whitespace() {
                return Some([first, self.bytes.get(self.at + 1).copied().unwrap_or(b'\n')]);
            }
            self.at += 1;
        }
    }

    /// Passes over the statement's first `count` bytes.
    #[inline]
    pub(crate) fn advance(&mut self, count: usize) {
        self.at = (self.at + count).min(self.bytes.len());
    }

    /// Passes over the rest of the statement with its continuations. Comments have none: a path that ends in `\` must
    /// not swallow the next line.
    #[inline]
    pub(crate) fn finish_statement(&mut self) {
        if self.bytes.get(self.at) == Some(&b'\n') {
            self.at += 1;
            return;
        }
        self.skip_lines();
    }

    fn skip_lines(&mut self) {
        let is_comment = self.bytes.get(self.at) == Some(&b'#');
        loop {
            let start = self.at;
            let Some(length) = memchr(b'\n', &self.bytes[start..]) else {
                self.at = self.bytes.len();
                return;
            };
            self.at += length + 1;
            let line = &self.bytes[start..start + length];
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if is_comment || !line.ends_with(b"\\") || memchr(b'#', line).is_some() {
                return;
            }
        }
    }

    /// Passes over blanks inside the statement; returns the next byte, `None` at its end (also at a `#`).
    #[inline]
    fn next_byte(&mut self) -> Option<u8> {
        loop {
            match self.bytes.get(self.at) {
                Some(b' ' | b'\t' | b'\r' | 0x0b | 0x0c) => self.at += 1,
                Some(b'\\') => match self.continuation() {
                    Some(length) => self.at += length,
                    None => return Some(b'\\'),
                },
                None | Some(b'\n' | b'#') => return None,
                Some(&byte) => return Some(byte),
            }
        }
    }

    /// Bytes of the `\` and line end that stand here, if they do.
    fn continuation(&self) -> Option<usize> {
        match self.bytes.get(self.at + 1..)? {
            [] => Some(1),
            [b'\n', ..] | [b'\r'] => Some(2),
            [b'\r', b'\n', ..] => Some(3),
            _ => None,
        }
    }

    /// The next number of the statement, `None` at its end.
    #[inline]
    pub(crate) fn number(&mut self) -> Result<Option<f64>, Fault> {
        if self.next_byte().is_none() {
            return Ok(None);
        }
        match fast_float2::parse_partial::<f64, _>(&self.bytes[self.at..]) {
            Ok((value, length)) if length > 0 => {
                self.at += length;
                self.check_end_of_number();
                Ok(Some(value))
            }
            _ => Err(self.fault("this is no number")),
        }
    }

    #[inline]
    fn check_end_of_number(&mut self) {
        match self.bytes.get(self.at) {
            None | Some(b' ' | b'\n' | b'\r' | b'\t' | b'#' | b'\\') => {}
            Some(_) => {
                self.odd_numbers += 1;
                self.skip_word();
            }
        }
    }

    /// The position index of the next corner (`a`, `a/b`, `a//c`, `a/b/c`, `a/b/`), `None` at the statement's end.
    /// Indices beyond 2^33 come back as 2^33: out of any range.
    #[inline]
    pub(crate) fn corner(&mut self) -> Result<Option<i64>, Fault> {
        let Some(sign) = self.next_byte() else { return Ok(None) };
        if sign == b'-' || sign == b'+' {
            self.at += 1;
        }
        let start = self.at;
        let mut index: i64 = 0;
        while let Some(digit @ b'0'..=b'9') = self.bytes.get(self.at) {
            index = (index * 10 + i64::from(digit - b'0')).min(1 << 33);
            self.at += 1;
        }
        match self.bytes.get(self.at) {
            _ if self.at == start => return Err(self.fault("this is no vertex index")),
            None | Some(b' ' | b'\n' | b'\r' | b'\t' | b'#' | b'\\') => {}
            Some(b'/') => self.skip_word(),
            Some(_) => return Err(self.fault("this is no vertex index")),
        }
        Ok(Some(if sign == b'-' { -index } else { index }))
    }

    /// Passes over the rest of a word. A `\` ends it only where it continues the line.
    #[inline]
    fn skip_word(&mut self) {
        while let Some(byte) = self.bytes.get(self.at) {
            if byte.is_ascii_whitespace() || (*byte == b'\\' && self.continuation().is_some()) {
                return;
            }
            self.at += 1;
        }
    }

    /// The rest of the line as it stands, without blanks round it.
    pub(crate) fn rest_of_line(&self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        rest[..memchr(b'\n', rest).unwrap_or(rest.len())].trim_ascii()
    }

    /// A fault on the line where the scanner stands.
    pub(crate) fn fault(&self, problem: impl Into<String>) -> Fault {
        Fault::malformed(line_at(self.bytes, self.at), problem)
    }
}

/// The line that holds offset `at`.
pub(crate) fn line_at(bytes: &[u8], at: usize) -> Place {
    Place::Line(memchr_iter(b'\n', &bytes[..at.min(bytes.len())]).count() as u64 + 1)
}

/// Offset of the first statement: after a UTF-8 mark.
///
/// # Errors
/// `Unsupported` for UTF-16 text, with or without a mark.
pub(crate) fn check_text(bytes: &[u8]) -> Result<usize, Fault> {
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, _, ..] | [_, 0, ..] => {
            Err(Fault::unsupported(Place::Byte(0), "UTF-16 text", "save the file as UTF-8 or ASCII"))
        }
        [0xef, 0xbb, 0xbf, ..] => Ok(3),
        _ => Ok(0),
    }
}
