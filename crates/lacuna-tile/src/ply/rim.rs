//! Positions and colours of single vertices of a PLY body.

use super::cursor::Cursor;
use super::header::{Element, Encoding, Header, Kind};
use super::read::{Position, offset_in_row};
use super::rows::{Role, roles};
use super::scalar::{Endian, Scalar};
use crate::fault::Fault;
use glam::DVec3;

/// A vertex as the file stores it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StoredVertex {
    pub(crate) position: DVec3,
    /// In the units of the colour properties' own types; zero without colours.
    pub(crate) colour: [f64; 3],
}

/// Calls `visit` with the vertices of `ids` (ascending) in order. Every id must be below the element's count, and the
/// body must have been walked before (so that all rows are there).
pub(crate) fn visit_vertices(
    header: &Header,
    bytes: &[u8],
    position: &Position,
    start: usize,
    ids: impl Iterator<Item = u32>,
    mut visit: impl FnMut(StoredVertex),
) -> Result<(), Fault> {
    let vertex = &header.elements[position.element];
    let roles = roles(vertex);
    if let (Encoding::Binary(endian), Some(size)) = (header.encoding, vertex.row_size()) {
        let columns = columns(vertex, &roles);
        for id in ids {
            let from = start + size * id as usize;
            visit(decode_row(&bytes[from..from + size], &columns, endian));
        }
        return Ok(());
    }
    let mut cursor = Cursor::new(bytes, start, header.encoding);
    let mut next = 0;
    for id in ids {
        while next < id {
            cursor.skip_row(vertex)?;
            next += 1;
        }
        visit(read_row(&mut cursor, vertex, &roles)?);
        next += 1;
    }
    Ok(())
}

/// Mean colour of some vertices; `None` if there are none.
pub(crate) fn mean_colour(vertices: &[StoredVertex]) -> Option<[f64; 3]> {
    let count = vertices.len() as f64;
    let sum = |channel: usize| vertices.iter().map(|v| v.colour[channel]).sum::<f64>();
    (!vertices.is_empty()).then(|| [0, 1, 2].map(|channel| sum(channel) / count))
}

/// Where rows of one size hold what is wanted.
struct Column {
    role: Role,
    offset: usize,
    scalar: Scalar,
}

fn columns(vertex: &Element, roles: &[Role]) -> Vec<Column> {
    let all = vertex.properties.iter().zip(roles).enumerate();
    let wanted = all.filter_map(|(index, (property, role))| match (property.kind, role) {
        (Kind::Scalar(scalar), Role::Position(_) | Role::Colour(_)) => {
            Some(Column { role: *role, offset: offset_in_row(vertex, index), scalar })
        }
        _ => None,
    });
    wanted.collect()
}

fn decode_row(row: &[u8], columns: &[Column], endian: Endian) -> StoredVertex {
    let mut vertex = StoredVertex::default();
    for column in columns {
        vertex.set(column.role, column.scalar.decode(&row[column.offset..], endian));
    }
    vertex
}

fn read_row(cursor: &mut Cursor<'_>, element: &Element, roles: &[Role]) -> Result<StoredVertex, Fault> {
    let mut vertex = StoredVertex::default();
    cursor.begin_row();
    for (property, role) in element.properties.iter().zip(roles) {
        match property.kind {
            Kind::Scalar(scalar) => vertex.set(*role, cursor.scalar(scalar)?),
            kind @ Kind::List { .. } => cursor.skip_value(kind)?,
        }
    }
    cursor.end_row();
    Ok(vertex)
}

impl StoredVertex {
    fn set(&mut self, role: Role, value: f64) {
        match role {
            Role::Position(axis) => self.position[axis] = value,
            Role::Colour(channel) => self.colour[channel] = value,
            Role::Normal(_) | Role::Alpha | Role::Other => {}
        }
    }
}
