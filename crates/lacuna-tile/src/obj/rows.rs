//! Where the vertex rows of an OBJ file stand, and what single rows hold.

use super::scanner::{Scanner, check_text};
use crate::fault::Fault;
use glam::DVec3;

/// What a writer needs to know of an OBJ file.
pub(crate) struct Rows<'a> {
    bytes: &'a [u8],
    /// Offset of each `v` statement, in order.
    vertices: Vec<usize>,
    /// Number of `vn` statements.
    pub(crate) normals: u64,
    /// How many numbers the coloured `v` statements have beyond the position: 3 or 4, 0 without colours.
    pub(crate) colour_columns: usize,
    /// How the first line ends.
    pub(crate) newline: &'static str,
}

/// A vertex as the file stores it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StoredVertex {
    pub(crate) position: DVec3,
    /// The numbers beyond the position, if the row has as many as the file's colours.
    pub(crate) colour: Option<[f64; 4]>,
}

/// Walks the file's statements without reading their numbers (but those of the first coloured row).
pub(crate) fn find_rows(bytes: &[u8]) -> Result<Rows<'_>, Fault> {
    let mut scanner = Scanner::new(bytes, check_text(bytes)?);
    let mut rows =
        Rows { bytes, vertices: Vec::new(), normals: 0, colour_columns: 0, newline: newline(bytes) };
    while let Some(start) = scanner.next_statement() {
        match start {
            [b'v', b' ' | b'\t' | b'\r' | b'\n' | b'\\'] => rows.vertices.push(scanner.offset()),
            [b'v', b'n'] => rows.normals += 1,
            _ => {}
        }
        scanner.finish_statement();
    }
    rows.colour_columns = rows.find_colour_columns()?;
    Ok(rows)
}

fn newline(bytes: &[u8]) -> &'static str {
    match memchr::memchr(b'\n', bytes) {
        Some(at) if bytes[..at].ends_with(b"\r") => "\r\n",
        _ => "\n",
    }
}

impl Rows<'_> {
    /// Number of vertices.
    pub(crate) fn vertex_count(&self) -> u64 {
        self.vertices.len() as u64
    }

    /// The vertex of an id, which must be below the count.
    pub(crate) fn vertex(&self, id: u32) -> Result<StoredVertex, Fault> {
        let numbers = self.numbers(self.vertices[id as usize])?;
        let colour = (self.colour_columns > 0 && numbers.len() == 3 + self.colour_columns).then(|| {
            let mut colour = [0.0; 4];
            colour[..self.colour_columns].copy_from_slice(&numbers[3..]);
            colour
        });
        let position = [0, 1, 2].map(|k| numbers.get(k).copied().unwrap_or(f64::NAN));
        Ok(StoredVertex { position: DVec3::from(position), colour })
    }

    /// Mean colour of the coloured ones among some vertices; `None` if there is none.
    pub(crate) fn mean_colour(
        &self,
        vertices: impl Iterator<Item = Result<StoredVertex, Fault>>,
    ) -> Result<Option<[f64; 4]>, Fault> {
        let (mut sum, mut count) = ([0.0; 4], 0.0);
        for vertex in vertices {
            if let Some(colour) = vertex?.colour {
                sum.iter_mut().zip(colour).for_each(|(total, channel)| *total += channel);
                count += 1.0;
            }
        }
        Ok((count > 0.0).then(|| sum.map(|channel| channel / count)))
    }

    /// Mean colour of all coloured vertices.
    pub(crate) fn tile_colour(&self) -> Result<Option<[f64; 4]>, Fault> {
        self.mean_colour((0..self.vertices.len()).map(|id| self.vertex(id as u32)))
    }

    /// All rows are looked at: the reader calls a file coloured if a single row is.
    fn find_colour_columns(&self) -> Result<usize, Fault> {
        for &offset in &self.vertices {
            let count = self.numbers(offset)?.len();
            if count >= 6 {
                return Ok((count - 3).min(4));
            }
        }
        Ok(0)
    }

    /// At most seven numbers of a `v` statement.
    fn numbers(&self, offset: usize) -> Result<Vec<f64>, Fault> {
        let mut scanner = Scanner::new(self.bytes, offset);
        scanner.advance(1);
        let mut numbers = Vec::with_capacity(7);
        while let Some(number) = scanner.number()? {
            if numbers.len() < 7 {
                numbers.push(number);
            }
        }
        Ok(numbers)
    }
}
