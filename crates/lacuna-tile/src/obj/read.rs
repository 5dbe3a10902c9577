//! The mesh of an OBJ file.

use super::scanner::{Scanner, check_text, line_at};
use crate::error::TileError;
use crate::fault::Fault;
use crate::mesh::{drop_non_finite, turn_to_scene};
use crate::polygon::cut_polygon;
use crate::source::load;
use crate::types::{NumberType, ReadOptions, ReadTile, UpAxis, VertexFrame};
use glam::DVec3;
use lacuna_mesh::TriMesh;
use std::path::Path;

/// Reads an OBJ tile: one read of the file, hashed, parsed from that buffer.
///
/// # Errors
/// As `read_tile`.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<ReadTile, TileError> {
    let source = load(path, options)?;
    let mut parsed = parse(&source.bytes).map_err(|fault| fault.at(path))?;
    let up_axis = options.up_axis.unwrap_or(UpAxis::Z);
    turn_to_scene(&mut parsed.mesh.positions, up_axis);
    Ok(ReadTile {
        mesh: parsed.mesh,
        frame: frame(up_axis),
        hash: source.hash,
        bytes: source.bytes.len() as u64,
        has_colour: parsed.has_colour,
        textures: parsed.libraries,
        warnings: parsed.warnings,
    })
}

/// The frame of an OBJ with this up axis.
pub(crate) fn frame(up_axis: UpAxis) -> VertexFrame {
    VertexFrame { number: NumberType::Decimal, to_scene: up_axis.to_scene() }
}

/// What the file holds, in its own frame.
struct Parsed {
    mesh: TriMesh,
    has_colour: bool,
    libraries: Vec<String>,
    warnings: Vec<String>,
}

fn parse(bytes: &[u8]) -> Result<Parsed, Fault> {
    let mut scanner = Scanner::new(bytes, check_text(bytes)?);
    let mut reader = Reader::default();
    while let Some(start) = scanner.next_statement() {
        match start {
            [b'v', b' ' | b'\t' | b'\r' | b'\n' | b'\\'] => reader.vertex(&mut scanner)?,
            [b'f', b' ' | b'\t' | b'\r' | b'\n' | b'\\'] => reader.face(&mut scanner)?,
            [b'm', b't'] => reader.library(&scanner),
            _ => {}
        }
        scanner.finish_statement();
    }
    reader.finish(bytes, scanner.odd_numbers)
}

/// The columns so far.
#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    has_colour: bool,
    libraries: Vec<String>,
    corners: Vec<u32>,
    short_faces: u64,
    /// Highest index so far, and the offset behind it: judged at the end, since faces may stand before vertices.
    highest: Option<(u32, usize)>,
    /// Polygons that name vertices further down: their first triangle, and their corners.
    late: Vec<(usize, Vec<u32>)>,
}

impl Reader {
    fn vertex(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Fault> {
        scanner.advance(1);
        let position = [scanner.number()?, scanner.number()?, scanner.number()?];
        let [Some(x), Some(y), Some(z)] = position else {
            return Err(scanner.fault("a vertex needs three numbers"));
        };
        self.positions.push(DVec3::new(x, y, z));
        let mut count = 3;
        while scanner.number()?.is_some() {
            count += 1;
        }
        self.has_colour |= count >= 6;
        Ok(())
    }

    fn face(&mut self, scanner: &mut Scanner<'_>) -> Result<(), Fault> {
        scanner.advance(1);
        self.corners.clear();
        while let Some(index) = scanner.corner()? {
            let corner = self.resolve(index, scanner)?;
            self.corners.push(corner);
        }
        let known = self.positions.len();
        match self.corners[..] {
            [a, b, c] => self.triangles.push([a, b, c]),
            [] | [_] | [_, _] => self.short_faces += 1,
            _ if self.corners.iter().all(|&c| (c as usize) < known) => {
                cut_polygon(&self.corners, &self.positions, &mut self.triangles);
            }
            _ => {
                self.late.push((self.triangles.len(), self.corners.clone()));
                self.triangles.extend(std::iter::repeat_n([0; 3], self.corners.len() - 2));
            }
        }
        Ok(())
    }

    /// A file index (from 1, or negative from the last vertex) as an index from 0.
    #[inline]
    fn resolve(&mut self, index: i64, scanner: &Scanner<'_>) -> Result<u32, Fault> {
        let known = self.positions.len() as i64;
        let corner = if index < 0 { known + index } else { index - 1 };
        match u32::try_from(corner) {
            Ok(corner) => {
                if self.highest.is_none_or(|(highest, _)| corner > highest) {
                    self.highest = Some((corner, scanner.offset()));
                }
                Ok(corner)
            }
            Err(_) if index == 0 => Err(scanner.fault("index 0: OBJ counts from 1")),
            Err(_) => Err(scanner.fault(format!("index {index}, but {known} vertices stand above"))),
        }
    }

    /// The rest of the line is one name: names may hold spaces.
    fn library(&mut self, scanner: &Scanner<'_>) {
        let line = scanner.rest_of_line();
        if let Some(name) =
            line.strip_prefix(b"mtllib").filter(|n| n.starts_with(b" ") || n.starts_with(b"\t"))
        {
            self.libraries.push(String::from_utf8_lossy(name.trim_ascii()).into_owned());
        }
    }

    fn finish(mut self, bytes: &[u8], odd_numbers: u64) -> Result<Parsed, Fault> {
        let count = self.positions.len();
        if u32::try_from(count).is_err() {
            let advice = "cut the tile";
            return Err(Fault::unsupported(line_at(bytes, 0), format!("{count} vertices"), advice));
        }
        if let Some((highest, offset)) = self.highest.filter(|(highest, _)| *highest as usize >= count) {
            let problem = format!("index {}, but the file has {count} vertices", u64::from(highest) + 1);
            return Err(Fault::malformed(line_at(bytes, offset), problem));
        }
        for (first, corners) in &self.late {
            let mut triangles = Vec::new();
            cut_polygon(corners, &self.positions, &mut triangles);
            self.triangles[*first..first + triangles.len()].copy_from_slice(&triangles);
        }
        let mut mesh = TriMesh { positions: self.positions, triangles: self.triangles };
        let mut warnings = drop_non_finite(&mut mesh);
        let counted = [
            (self.short_faces, "faces with fewer than three corners passed over"),
            (odd_numbers, "numbers with an unreadable end; what stands before it counts"),
        ];
        warnings.extend(counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
        Ok(Parsed { mesh, has_colour: self.has_colour, libraries: self.libraries, warnings })
    }
}
