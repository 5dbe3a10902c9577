//! Appends patches to a PLY file: new counts and comments in the header, patch rows after the original ones, nothing
//! else.

use super::cursor::Cursor;
use super::header::{Element, Encoding, Header, Kind, parse_header};
use super::read::{Position, find_index_list, find_position, frame};
use super::rim::{StoredVertex, mean_colour, visit_vertices};
use super::rows::{Role, RowWriter, plain_face_element, roles};
use crate::atomic::AtomicFile;
use crate::error::{Place, TileError};
use crate::fault::Fault;
use crate::patches::{
    check_patches, comment_text, count_triangles, count_vertices, original_corners, to_file_frame,
};
use crate::source::load_expected;
use crate::types::{AppendRequest, Corner, HolePatch, NewTileRequest, ReadOptions, UpAxis, Written};
use std::io::Write;
use std::ops::Range;
use std::path::Path;

/// Writes a PLY tile again with patches appended.
///
/// # Errors
/// As `append_patches`.
pub(crate) fn append(request: &AppendRequest<'_>) -> Result<Written, TileError> {
    let source = load_expected(request.input, request.options, request.expected_hash)?;
    if request.patches.is_empty() {
        return write_pieces(request.output, &[&source.bytes]);
    }
    let tile = Tile::parse(request.input, &source.bytes, request.options)?;
    check_patches(request.input, request.patches, tile.vertex_count())?;
    tile.check_index_type(request.input, request.patches, tile.vertex_count())?;
    let rows =
        tile.patch_rows(request.patches, tile.vertex_count()).map_err(|fault| fault.at(request.input))?;
    let header = tile.rewrite_header(request.patches, true);
    let vertices = tile.insertion(tile.spans[tile.position.element].end, rows.vertices);
    let end = tile.spans.last().map_or(tile.header.body, |span| span.end);
    let faces = tile.insertion(tile.face.map_or(end, |face| tile.spans[face].end), rows.faces);
    let face_is_first = tile.face.is_some_and(|face| face < tile.position.element);
    let [first, mut second] = if face_is_first { [faces, vertices] } else { [vertices, faces] };
    if second.at == first.at {
        second.lead = b""; // the first one has closed the line
    }
    let [head, middle, tail] =
        [tile.header.body..first.at, first.at..second.at, second.at..source.bytes.len()]
            .map(|range| &source.bytes[range]);
    let pieces = [&header, head, first.lead, &first.rows, middle, second.lead, &second.rows, tail];
    write_pieces(request.output, &pieces)
}

/// Writes a PLY tile of patches alone, with the header, properties, types and encoding of the template.
///
/// # Errors
/// As `new_tile`.
pub(crate) fn new_tile(request: &NewTileRequest<'_>) -> Result<Written, TileError> {
    let source = load_expected(request.template, request.options, None)?;
    let tile = Tile::parse(request.template, &source.bytes, request.options)?;
    check_patches(request.output, request.patches, 0)?;
    tile.check_index_type(request.template, request.patches, 0)?;
    let rows = tile.patch_rows(request.patches, 0).map_err(|fault| fault.at(request.template))?;
    let header = tile.rewrite_header(request.patches, false);
    let face_is_first = tile.face.is_some_and(|face| face < tile.position.element);
    let [first, second] =
        if face_is_first { [&rows.faces, &rows.vertices] } else { [&rows.vertices, &rows.faces] };
    write_pieces(request.output, &[&header, first, second])
}

fn write_pieces(output: &Path, pieces: &[&[u8]]) -> Result<Written, TileError> {
    let mut file = AtomicFile::create(output)?;
    for piece in pieces {
        file.write_all(piece).map_err(|e| TileError::io(output, "write", e))?;
    }
    let committed = file.commit()?;
    Ok(Written { bytes: committed.bytes, hash: committed.hash, side_files: Vec::new() })
}

/// A parsed input, with the byte range of each element's rows.
struct Tile<'a> {
    bytes: &'a [u8],
    header: Header,
    position: Position,
    up_axis: UpAxis,
    spans: Vec<Range<usize>>,
    /// Index of the face element, if there is one.
    face: Option<usize>,
    /// The face element, or the one that will be added.
    face_element: Element,
    /// Its property of vertex indices.
    face_list: usize,
}

/// Rows that go in at one place.
struct Insertion {
    at: usize,
    /// Closes a last line that has no end.
    lead: &'static [u8],
    rows: Vec<u8>,
}

/// Rows of all patches.
struct PatchRows {
    vertices: Vec<u8>,
    faces: Vec<u8>,
}

impl<'a> Tile<'a> {
    fn parse(path: &Path, bytes: &'a [u8], options: &ReadOptions) -> Result<Self, TileError> {
        let up_axis = options.up_axis.unwrap_or(UpAxis::Z);
        Self::parse_bytes(bytes, up_axis).map_err(|fault| fault.at(path))
    }

    fn parse_bytes(bytes: &'a [u8], up_axis: UpAxis) -> Result<Self, Fault> {
        let header = parse_header(bytes)?;
        let position = find_position(&header)?;
        if position.scalars.iter().any(|s| !s.is_float()) {
            let place = Place::Line(header.elements[position.element].line);
            let advice = "convert the tile to float or double coordinates";
            return Err(Fault::unsupported(place, "new vertices on coordinates of whole numbers", advice));
        }
        let mut cursor = Cursor::new(bytes, header.body, header.encoding);
        let mut spans = Vec::new();
        for element in &header.elements {
            let start = cursor.offset();
            cursor.skip(element)?;
            spans.push(start..cursor.offset());
        }
        let face = header.find("face");
        let face_element = face.map_or_else(plain_face_element, |index| header.elements[index].clone());
        let face_list = find_index_list(&face_element)?;
        Ok(Self { bytes, header, position, up_axis, spans, face, face_element, face_list })
    }

    fn vertex_count(&self) -> u64 {
        self.header.elements[self.position.element].count
    }

    /// Fails if the faces' index type can't name every corner of the patches when `before` vertices precede them.
    fn check_index_type(&self, path: &Path, patches: &[HolePatch], before: u64) -> Result<(), TileError> {
        let Kind::List { value, .. } = self.face_element.properties[self.face_list].kind else {
            return Ok(());
        };
        let largest = value.largest_index().min(u64::from(u32::MAX));
        let originals = patches.iter().flat_map(original_corners).map(u64::from).max();
        let new = count_vertices(patches);
        let needed = originals.max((new > 0).then(|| before + new - 1)).unwrap_or(0);
        if needed <= largest {
            return Ok(());
        }
        Err(TileError::IndexTypeTooSmall {
            path: path.to_owned(),
            place: Place::Line(self.face_element.properties[self.face_list].line),
            index_type: value.name().to_owned(),
            largest,
            needed,
        })
    }

    fn patch_rows(&self, patches: &[HolePatch], before: u64) -> Result<PatchRows, Fault> {
        let vertex = &self.header.elements[self.position.element];
        let (vertex_roles, face_roles) = (roles(vertex), roles(&self.face_element));
        let [mut vertices, mut faces] =
            [(); 2].map(|()| RowWriter::new(self.header.encoding, self.header.newline));
        let rim = Rim::gather(self, patches)?;
        let frame = frame(self.position.number(), self.up_axis);
        let mut first_new = before;
        for patch in patches {
            let ids = original_corners(patch);
            let stored = rim.pick(&ids);
            let colour = rim.colour(&stored);
            let positions: Vec<_> = stored.iter().map(|v| v.position).collect();
            let local = to_file_frame(patch, &frame, &ids, &positions);
            for (position, normal) in local.vertices.iter().zip(&local.normals) {
                vertices.vertex(vertex, &vertex_roles, *position, *normal, colour);
            }
            for triangle in &patch.triangles {
                let corners = triangle.map(|corner| match corner {
                    Corner::Original(v) => v.0,
                    Corner::New(k) => (first_new + u64::from(k)) as u32, // check_index_type: below 2^32
                });
                faces.face(&self.face_element, &face_roles, self.face_list, corners, colour);
            }
            first_new += patch.vertices.len() as u64;
        }
        Ok(PatchRows { vertices: vertices.bytes, faces: faces.bytes })
    }

    fn insertion(&self, at: usize, rows: Vec<u8>) -> Insertion {
        let is_open = self.header.encoding == Encoding::Ascii && !self.bytes[..at].ends_with(b"\n");
        let lead = if is_open && !rows.is_empty() { self.header.newline.as_bytes() } else { b"" };
        Insertion { at, lead, rows }
    }

    /// The header with new counts and a comment for every hole. Appending keeps the other bytes; a new tile leaves out
    /// the lines that speak of the template's own rows and textures, and has no rows in other elements.
    fn rewrite_header(&self, patches: &[HolePatch], is_append: bool) -> Vec<u8> {
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        let (vertices, triangles) = (count_vertices(patches), count_triangles(patches));
        for (index, element) in self.header.elements.iter().enumerate() {
            let before = if is_append { element.count } else { 0 };
            let added = match index {
                _ if index == self.position.element => vertices,
                _ if Some(index) == self.face => triangles,
                _ => 0,
            };
            if before + added != element.count {
                edits.push((element.count_span.clone(), (before + added).to_string()));
            }
        }
        if !is_append {
            edits.extend(self.header.own_lines.iter().map(|line| (line.clone(), String::new())));
        }
        edits.sort_by_key(|(range, _)| range.start);
        let end = self.header.end_line;
        edits.push((end..end, self.added_lines(patches, is_append)));
        splice(&self.bytes[..self.header.body], &edits)
    }

    /// What goes in before `end_header`.
    fn added_lines(&self, patches: &[HolePatch], is_append: bool) -> String {
        let newline = self.header.newline;
        let mut lines = String::new();
        if self.face.is_none() {
            let count = count_triangles(patches);
            lines += &format!("element face {count}{newline}property list uchar int vertex_indices{newline}");
        }
        let mut vertex = if is_append { self.vertex_count() } else { 0 };
        let mut face = self.face.filter(|_| is_append).map_or(0, |index| self.header.elements[index].count);
        for patch in patches {
            let (vertices, faces) = (patch.vertices.len() as u64, patch.triangles.len() as u64);
            let hole = comment_text(&patch.hole);
            let (v, f) = (inclusive(vertex, vertices), inclusive(face, faces));
            lines += &format!("comment lacuna patch: vertices {v} faces {f} hole {hole}{newline}");
            vertex += vertices;
            face += faces;
        }
        lines
    }
}

/// `first..last`, both included, or `none`.
fn inclusive(first: u64, count: u64) -> String {
    match count {
        0 => "none".to_owned(),
        _ => format!("{first}..{}", first + count - 1),
    }
}

/// Replaces ranges (ascending, disjoint) of `bytes`.
fn splice(bytes: &[u8], edits: &[(Range<usize>, String)]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    for (range, text) in edits {
        out.extend_from_slice(&bytes[at..range.start]);
        out.extend_from_slice(text.as_bytes());
        at = range.end;
    }
    out.extend_from_slice(&bytes[at..]);
    out
}

/// The original vertices that any patch joins, and the tile's mean colour for patches that join none.
struct Rim {
    ids: Vec<u32>,
    vertices: Vec<StoredVertex>,
    has_colour: bool,
    tile_colour: [f64; 3],
}

impl Rim {
    fn gather(tile: &Tile<'_>, patches: &[HolePatch]) -> Result<Self, Fault> {
        let mut ids: Vec<u32> = patches.iter().flat_map(original_corners).collect();
        ids.sort_unstable();
        ids.dedup();
        let mut vertices = Vec::with_capacity(ids.len());
        let start = tile.spans[tile.position.element].start;
        let visit = |ids: &mut dyn Iterator<Item = u32>, sink: &mut dyn FnMut(StoredVertex)| {
            visit_vertices(&tile.header, tile.bytes, &tile.position, start, ids, sink)
        };
        visit(&mut ids.iter().copied(), &mut |v| vertices.push(v))?;
        let mut tile_colour = middle_colour(tile);
        let has_colour = roles(&tile.header.elements[tile.position.element]).contains(&Role::Colour(0));
        let is_needed = patches.iter().any(|patch| original_corners(patch).is_empty());
        if is_needed && has_colour {
            let mut all = Vec::new();
            visit(&mut (0..tile.vertex_count() as u32), &mut |v| all.push(v))?;
            tile_colour = mean_colour(&all).unwrap_or(tile_colour);
        }
        Ok(Self { ids, vertices, has_colour, tile_colour })
    }

    /// The mean colour of a patch's rim, else the tile's.
    fn colour(&self, rim: &[StoredVertex]) -> [f64; 3] {
        mean_colour(rim).filter(|_| self.has_colour).unwrap_or(self.tile_colour)
    }

    /// The vertices of `ids`, which must all have been gathered.
    fn pick(&self, ids: &[u32]) -> Vec<StoredVertex> {
        ids.iter().filter_map(|id| self.ids.binary_search(id).ok()).map(|k| self.vertices[k]).collect()
    }
}

/// Half of a full channel of the first colour property: what a tile without a single coloured vertex gets.
fn middle_colour(tile: &Tile<'_>) -> [f64; 3] {
    let vertex = &tile.header.elements[tile.position.element];
    let channel = [vertex, &tile.face_element].into_iter().find_map(|element| {
        element.properties.iter().zip(roles(element)).find_map(|(property, role)| {
            match (property.kind, role) {
                (Kind::Scalar(scalar), Role::Colour(_)) => Some(scalar.full_channel() / 2.0),
                _ => None,
            }
        })
    });
    [channel.unwrap_or(0.0); 3]
}
