//! Writes the rows that a patch adds to a PLY body.

use super::header::{Element, Encoding, Kind, Property};
use super::scalar::Scalar;
use glam::DVec3;

/// What a patch row puts into a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Position(usize),
    Normal(usize),
    Colour(usize),
    Alpha,
    Other,
}

/// The roles of an element's properties, by their names.
pub(crate) fn roles(element: &Element) -> Vec<Role> {
    element.properties.iter().map(|p| role(&p.name, p.kind)).collect()
}

fn role(name: &str, kind: Kind) -> Role {
    if matches!(kind, Kind::List { .. }) {
        return Role::Other;
    }
    let colour = name.strip_prefix("diffuse_").unwrap_or(name);
    let find = |names: [&str; 3], name: &str| names.iter().position(|n| *n == name);
    if let Some(axis) = find(["x", "y", "z"], name) {
        Role::Position(axis)
    } else if let Some(axis) = find(["nx", "ny", "nz"], name) {
        Role::Normal(axis)
    } else if let Some(channel) = find(["red", "green", "blue"], colour) {
        Role::Colour(channel)
    } else if colour == "alpha" {
        Role::Alpha
    } else {
        Role::Other
    }
}

/// Rows in the making.
pub(crate) struct RowWriter {
    encoding: Encoding,
    newline: &'static str,
    is_row_begun: bool,
    /// The bytes so far.
    pub(crate) bytes: Vec<u8>,
}

impl RowWriter {
    /// Starts with no rows.
    pub(crate) fn new(encoding: Encoding, newline: &'static str) -> Self {
        Self { encoding, newline, is_row_begun: false, bytes: Vec::new() }
    }

    /// A row of the vertex element. `colour` is in the units of the colour properties' own types.
    pub(crate) fn vertex(
        &mut self,
        element: &Element,
        roles: &[Role],
        position: DVec3,
        normal: DVec3,
        colour: [f64; 3],
    ) {
        for (property, role) in element.properties.iter().zip(roles) {
            match (property.kind, *role) {
                (Kind::List { count, .. }, _) => self.value(count, 0.0),
                (Kind::Scalar(scalar), Role::Position(axis)) => self.value(scalar, position[axis]),
                (Kind::Scalar(scalar), Role::Normal(axis)) => self.value(scalar, normal[axis]),
                (Kind::Scalar(scalar), Role::Colour(channel)) => self.channel(scalar, colour[channel]),
                (Kind::Scalar(scalar), Role::Alpha) => self.value(scalar, scalar.full_channel()),
                (Kind::Scalar(scalar), Role::Other) => self.value(scalar, 0.0),
            }
        }
        self.end_row();
    }

    /// A row of the face element: `list` is its property of vertex indices. Colours are as in `vertex`.
    pub(crate) fn face(
        &mut self,
        element: &Element,
        roles: &[Role],
        list: usize,
        corners: [u32; 3],
        colour: [f64; 3],
    ) {
        for (index, (property, role)) in element.properties.iter().zip(roles).enumerate() {
            match (property.kind, *role) {
                (Kind::List { count, value }, _) if index == list => {
                    self.value(count, 3.0);
                    corners.iter().for_each(|&corner| self.value(value, f64::from(corner)));
                }
                (Kind::List { count, .. }, _) => self.value(count, 0.0),
                (Kind::Scalar(scalar), Role::Colour(channel)) => self.channel(scalar, colour[channel]),
                (Kind::Scalar(scalar), Role::Alpha) => self.value(scalar, scalar.full_channel()),
                (Kind::Scalar(scalar), _) => self.value(scalar, 0.0),
            }
        }
        self.end_row();
    }

    /// Colours round to the nearest whole number where their type is one.
    fn channel(&mut self, scalar: Scalar, value: f64) {
        self.value(scalar, if scalar.is_float() { value } else { value.round() });
    }

    fn value(&mut self, scalar: Scalar, value: f64) {
        match self.encoding {
            Encoding::Binary(endian) => scalar.encode(value, endian, &mut self.bytes),
            Encoding::Ascii => {
                if self.is_row_begun {
                    self.bytes.push(b' ');
                }
                self.bytes.extend_from_slice(scalar.print(value).as_bytes());
            }
        }
        self.is_row_begun = true;
    }

    fn end_row(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.bytes.extend_from_slice(self.newline.as_bytes());
        }
        self.is_row_begun = false;
    }
}

/// The face element that a file without one gets.
pub(crate) fn plain_face_element() -> Element {
    let kind = Kind::List { count: Scalar::U8, value: Scalar::I32 };
    let indices = Property { name: "vertex_indices".to_owned(), kind, line: 0 };
    Element { name: "face".to_owned(), count: 0, count_span: 0..0, properties: vec![indices], line: 0 }
}
