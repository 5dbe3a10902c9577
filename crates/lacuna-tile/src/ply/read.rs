//! The mesh of a PLY file.

use super::cursor::Cursor;
use super::header::{Element, Encoding, Header, Kind, parse_header};
use super::scalar::{Endian, Scalar, word};
use crate::error::{Place, TileError};
use crate::fault::{Fault, reserve};
use crate::mesh::{drop_non_finite, turn_to_scene};
use crate::polygon::cut_polygon;
use crate::source::load;
use crate::types::{NumberType, ReadOptions, ReadTile, UpAxis, VertexFrame};
use glam::DVec3;
use lacuna_mesh::TriMesh;
use std::path::Path;

/// Reads a PLY tile: one read of the file, hashed, parsed from that buffer.
///
/// # Errors
/// As `read_tile`.
pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<ReadTile, TileError> {
    let source = load(path, options)?;
    let header = parse_header(&source.bytes).map_err(|fault| fault.at(path))?;
    let mut parsed = parse(&header, &source.bytes).map_err(|fault| fault.at(path))?;
    let up_axis = options.up_axis.unwrap_or(UpAxis::Z);
    turn_to_scene(&mut parsed.mesh.positions, up_axis);
    Ok(ReadTile {
        mesh: parsed.mesh,
        frame: frame(parsed.number, up_axis),
        hash: source.hash,
        bytes: source.bytes.len() as u64,
        has_colour: parsed.has_colour,
        textures: header.textures,
        warnings: parsed.warnings,
    })
}

/// The frame of a file with this number type and up axis.
pub(crate) fn frame(number: NumberType, up_axis: UpAxis) -> VertexFrame {
    VertexFrame { number, to_scene: up_axis.to_scene() }
}

/// Index of the vertex element, and where its rows hold x, y, z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Position {
    pub(crate) element: usize,
    pub(crate) properties: [usize; 3],
    pub(crate) scalars: [Scalar; 3],
}

impl Position {
    /// How coordinates are stored: as f32 if any of the three is.
    pub(crate) fn number(&self) -> NumberType {
        if self.scalars.contains(&Scalar::F32) { NumberType::F32 } else { NumberType::F64 }
    }
}

/// Finds the vertex element and its x, y, z.
pub(crate) fn find_position(header: &Header) -> Result<Position, Fault> {
    let missing = || Fault::malformed(Place::File, "the header declares no element `vertex`");
    let element = header.find("vertex").ok_or_else(missing)?;
    let vertex = &header.elements[element];
    if vertex.count >= u64::from(u32::MAX) {
        let problem = format!("{} vertices, more than 2^32 - 2", vertex.count);
        return Err(Fault::unsupported(Place::Line(vertex.line), problem, "cut the tile"));
    }
    let [x, y, z] = ["x", "y", "z"].map(|name| find_coordinate(vertex, name));
    let ((x, sx), (y, sy), (z, sz)) = (x?, y?, z?);
    Ok(Position { element, properties: [x, y, z], scalars: [sx, sy, sz] })
}

fn find_coordinate(vertex: &Element, name: &str) -> Result<(usize, Scalar), Fault> {
    let missing = || Fault::malformed(Place::Line(vertex.line), format!("`vertex` has no property `{name}`"));
    let index = vertex.find(name).ok_or_else(missing)?;
    let property = &vertex.properties[index];
    match property.kind {
        Kind::Scalar(scalar) => Ok((index, scalar)),
        Kind::List { .. } => {
            Err(Fault::malformed(Place::Line(property.line), format!("the coordinate `{name}` is a list")))
        }
    }
}

/// What the body holds, in the file's own frame.
struct Parsed {
    mesh: TriMesh,
    number: NumberType,
    has_colour: bool,
    warnings: Vec<String>,
}

fn parse(header: &Header, bytes: &[u8]) -> Result<Parsed, Fault> {
    let position = find_position(header)?;
    let vertex_count = header.elements[position.element].count;
    let mut cursor = Cursor::new(bytes, header.body, header.encoding);
    let (mut positions, mut later) = (Vec::new(), Vec::new());
    let mut faces = Faces { vertex_count, triangles: Vec::new(), short_faces: 0 };
    for (index, element) in header.elements.iter().enumerate() {
        if index == position.element {
            positions = read_positions(&mut cursor, element, &position)?;
        } else if index < position.element {
            later.push((element, cursor.offset())); // polygons are cut by their corners' positions, which come below
            cursor.skip(element)?;
        } else {
            faces.read(&mut cursor, element, &positions)?;
        }
    }
    let left = cursor.rest().trim_ascii().len();
    let extra_tokens = cursor.extra_tokens();
    for (element, offset) in later {
        cursor.seek(offset);
        faces.read(&mut cursor, element, &positions)?;
    }
    let mut mesh = TriMesh { positions, triangles: faces.triangles };
    let mut warnings = drop_non_finite(&mut mesh);
    warn(&mut warnings, faces.short_faces, "faces with fewer than three corners passed over");
    warn(&mut warnings, extra_tokens, "rows with more values than declared; the surplus is passed over");
    warn(&mut warnings, left as u64, "bytes after the last element");
    let has_colour = header.elements[position.element].find("red").is_some();
    Ok(Parsed { mesh, number: position.number(), has_colour, warnings })
}

fn warn(warnings: &mut Vec<String>, count: u64, what: &str) {
    if count > 0 {
        warnings.push(format!("{count} {what}"));
    }
}

/// Reads the rows of the vertex element.
fn read_positions(
    cursor: &mut Cursor<'_>,
    vertex: &Element,
    position: &Position,
) -> Result<Vec<DVec3>, Fault> {
    cursor.check_count(vertex)?;
    let mut positions = Vec::new();
    reserve(&mut positions, vertex.count)?;
    if !read_fixed_rows(cursor, vertex, position, &mut positions) {
        for _ in 0..vertex.count {
            positions.push(read_position(cursor, vertex, position)?);
        }
    }
    Ok(positions)
}

fn read_position(cursor: &mut Cursor<'_>, vertex: &Element, position: &Position) -> Result<DVec3, Fault> {
    let mut values = [0.0; 3];
    cursor.begin_row();
    for (index, property) in vertex.properties.iter().enumerate() {
        match (position.properties.iter().position(|&p| p == index), property.kind) {
            (Some(axis), Kind::Scalar(scalar)) => values[axis] = cursor.scalar(scalar)?,
            (_, kind) => cursor.skip_value(kind)?,
        }
    }
    cursor.end_row();
    Ok(DVec3::from(values))
}

/// Fast path: little-endian rows of one size with x, y, z all float or all double. True if it applied.
fn read_fixed_rows(
    cursor: &mut Cursor<'_>,
    vertex: &Element,
    position: &Position,
    positions: &mut Vec<DVec3>,
) -> bool {
    let (Some(size), Some(rows)) = (vertex.row_size(), little_endian_rows(cursor, vertex)) else {
        return false;
    };
    let [x, y, z] = position.properties.map(|p| offset_in_row(vertex, p));
    match position.scalars {
        [Scalar::F32, Scalar::F32, Scalar::F32] => positions.extend(rows.chunks_exact(size).map(|row| {
            let at = |o: usize| f64::from(f32::from_le_bytes(word(&row[o..])));
            DVec3::new(at(x), at(y), at(z))
        })),
        [Scalar::F64, Scalar::F64, Scalar::F64] => positions.extend(rows.chunks_exact(size).map(|row| {
            let at = |o: usize| f64::from_le_bytes(word(&row[o..]));
            DVec3::new(at(x), at(y), at(z))
        })),
        _ => return false,
    }
    cursor.seek(cursor.offset() + rows.len());
    true
}

/// The bytes of all rows, if they are little-endian and of one size.
fn little_endian_rows<'a>(cursor: &Cursor<'a>, element: &Element) -> Option<&'a [u8]> {
    if cursor.encoding() != Encoding::Binary(Endian::Little) {
        return None;
    }
    let length = element.row_size()?.checked_mul(usize::try_from(element.count).ok()?)?;
    cursor.rest().get(..length)
}

/// Bytes before a property in rows without lists.
pub(crate) fn offset_in_row(element: &Element, property: usize) -> usize {
    let sizes = element.properties[..property].iter().map(|p| match p.kind {
        Kind::Scalar(scalar) => scalar.size(),
        Kind::List { .. } => 0,
    });
    sizes.sum()
}

/// Triangles of the face and strip elements read so far.
struct Faces {
    vertex_count: u64,
    triangles: Vec<[u32; 3]>,
    short_faces: u64,
}

impl Faces {
    /// Reads `face` and `tristrips`, passes over any other element.
    fn read(&mut self, cursor: &mut Cursor<'_>, element: &Element, positions: &[DVec3]) -> Result<(), Fault> {
        let is_strip = match element.name.as_str() {
            "face" => false,
            "tristrips" => true,
            _ => return cursor.skip(element),
        };
        let list = find_index_list(element)?;
        cursor.check_count(element)?;
        if !is_strip {
            reserve(&mut self.triangles, element.count)?;
        }
        let mut corners = Vec::new();
        let mut row = self.read_plain_triangles(cursor, element)?;
        while row < element.count {
            let place = || Place::Row { element: element.name.clone(), row };
            read_row_list(cursor, element, list, &mut corners)?;
            match is_strip {
                true => self.add_strip(&corners, place)?,
                false => self.add_face(&corners, positions, place)?,
            }
            row += 1;
        }
        Ok(())
    }

    /// Fast path: little-endian faces that hold nothing but a uchar count and 32-bit indices. Reads triangles up to the
    /// first row that isn't one and returns how many.
    fn read_plain_triangles(&mut self, cursor: &mut Cursor<'_>, element: &Element) -> Result<u64, Fault> {
        let is_plain = element.name == "face"
            && cursor.encoding() == Encoding::Binary(Endian::Little)
            && matches!(element.properties[..], [ref only] if matches!(only.kind,
                Kind::List { count: Scalar::U8, value: Scalar::I32 | Scalar::U32 }));
        if !is_plain {
            return Ok(0);
        }
        let wanted = usize::try_from(element.count).unwrap_or(usize::MAX);
        let rows = cursor.rest().chunks_exact(13).take(wanted).take_while(|bytes| bytes[0] == 3);
        let triangle = |bytes: &[u8]| [1, 5, 9].map(|o| u32::from_le_bytes(word(&bytes[o..])));
        let first = self.triangles.len();
        // One test for all: the largest index.
        let mut largest = 0;
        self.triangles.extend(rows.map(|bytes| {
            let [a, b, c] = triangle(bytes);
            largest = largest.max(a).max(b).max(c);
            [a, b, c]
        }));
        let read = &self.triangles[first..];
        if u64::from(largest) >= self.vertex_count
            && let Some(row) = read.iter().position(|t| t.iter().any(|&v| u64::from(v) >= self.vertex_count))
        {
            let place = Place::Row { element: element.name.clone(), row: row as u64 };
            return Err(self.out_of_range(read[row], place));
        }
        let rows = read.len();
        cursor.seek(cursor.offset() + 13 * rows);
        Ok(rows as u64)
    }

    fn add_face(
        &mut self,
        corners: &[f64],
        positions: &[DVec3],
        place: impl Fn() -> Place,
    ) -> Result<(), Fault> {
        let corners = corners.iter().map(|&c| self.index(c, &place)).collect::<Result<Vec<u32>, Fault>>()?;
        self.short_faces += u64::from(corners.len() < 3);
        cut_polygon(&corners, positions, &mut self.triangles);
        Ok(())
    }

    /// A strip: each corner makes a triangle with the two before it, every second one turned round; -1 starts anew.
    /// Joins that name a corner twice have no surface.
    fn add_strip(&mut self, corners: &[f64], place: impl Fn() -> Place) -> Result<(), Fault> {
        for strip in corners.split(|&c| c == -1.0) {
            let strip = strip.iter().map(|&c| self.index(c, &place)).collect::<Result<Vec<u32>, Fault>>()?;
            for (k, window) in strip.windows(3).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                if a != b && b != c && c != a {
                    self.triangles.push(if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
        Ok(())
    }

    fn index(&self, value: f64, place: &impl Fn() -> Place) -> Result<u32, Fault> {
        if value >= 0.0 && value < self.vertex_count as f64 && value.fract() == 0.0 {
            return Ok(value as u32); // vertex_count is below 2^32
        }
        Err(self.out_of_range(value, place()))
    }

    fn out_of_range(&self, what: impl std::fmt::Debug, place: Place) -> Fault {
        Fault::malformed(place, format!("vertex {what:?}, but there are {} vertices", self.vertex_count))
    }
}

/// The property that holds vertex indices.
pub(crate) fn find_index_list(element: &Element) -> Result<usize, Fault> {
    let problem = format!("`{}` has no list `vertex_indices` or `vertex_index`", element.name.escape_debug());
    let missing = Fault::malformed(Place::Line(element.line), problem);
    match element.find_indices() {
        Some(index) if matches!(element.properties[index].kind, Kind::List { .. }) => Ok(index),
        _ => Err(missing),
    }
}

/// Reads a row and keeps the values of one list.
fn read_row_list(
    cursor: &mut Cursor<'_>,
    element: &Element,
    list: usize,
    values: &mut Vec<f64>,
) -> Result<(), Fault> {
    values.clear();
    cursor.begin_row();
    for (index, property) in element.properties.iter().enumerate() {
        match property.kind {
            Kind::List { count, value } if index == list => {
                let length = cursor.list_length(count, value)?;
                for _ in 0..length {
                    values.push(cursor.scalar(value)?);
                }
            }
            kind => cursor.skip_value(kind)?,
        }
    }
    cursor.end_row();
    Ok(())
}
