//! Faces of a binary PLY file with the rows that hold them.

use super::faces::TileFaces;
use std::ops::Range;

/// A number's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Clone, Debug)]
struct Property {
    name: String,
    /// Type of the length, if a list.
    length: Option<Scalar>,
    value: Scalar,
}

#[derive(Clone, Debug)]
struct Element {
    name: String,
    count: usize,
    count_digits: Range<usize>,
    properties: Vec<Property>,
}

struct Header {
    big_endian: bool,
    elements: Vec<Element>,
    end: usize,
}

/// Reads positions and faces of a binary PLY, either byte order; other elements are stepped over.
pub(super) fn read(bytes: &[u8]) -> Result<TileFaces, String> {
    let header = header(bytes)?;
    let mut cursor = Cursor { bytes, at: header.end, big_endian: header.big_endian };
    let mut faces = TileFaces::default();
    for element in &header.elements {
        if element.count > bytes.len() {
            return Err(format!(
                "{} rows of {} can't be in {} bytes",
                element.count,
                element.name,
                bytes.len()
            ));
        }
        if element.name == "face" {
            faces.count = Some(element.count_digits.clone());
        }
        for _ in 0..element.count {
            read_row(&mut cursor, element, &mut faces)?;
        }
    }
    if faces.count.is_none() { Err("no element 'face'".to_owned()) } else { Ok(faces) }
}

fn read_row(cursor: &mut Cursor, element: &Element, faces: &mut TileFaces) -> Result<(), String> {
    let start = cursor.at;
    let mut position = [f64::NAN; 3];
    for property in &element.properties {
        let axis = ["x", "y", "z"].iter().position(|name| *name == property.name);
        let corners = element.name == "face" && property.name.starts_with("vertex_ind");
        match (property.length, axis) {
            (Some(length), _) => {
                read_list(cursor, length, property.value, corners.then_some(&mut faces.corners))?
            }
            (None, Some(axis)) => position[axis] = cursor.number(property.value)?,
            (None, None) => drop(cursor.number(property.value)?),
        }
    }
    match element.name.as_str() {
        "vertex" => faces.positions.push(position),
        "face" => {
            faces.ends.push(faces.corners.len());
            faces.bytes.push(start..cursor.at);
        }
        _ => {}
    }
    Ok(())
}

fn read_list(
    cursor: &mut Cursor,
    length: Scalar,
    value: Scalar,
    into: Option<&mut Vec<usize>>,
) -> Result<(), String> {
    let count = cursor.number(length)? as usize;
    match into {
        None => cursor.skip(count.saturating_mul(value.size())),
        Some(corners) => {
            for _ in 0..count {
                let index = cursor.number(value)?;
                corners.push(if index >= 0.0 { index as usize } else { usize::MAX });
            }
            Ok(())
        }
    }
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl Cursor<'_> {
    fn skip(&mut self, length: usize) -> Result<(), String> {
        let end = self.at.checked_add(length).filter(|&end| end <= self.bytes.len());
        self.at = end.ok_or_else(|| format!("the file ends early, in a row at byte {}", self.at))?;
        Ok(())
    }

    fn number(&mut self, kind: Scalar) -> Result<f64, String> {
        let start = self.at;
        self.skip(kind.size())?;
        let mut raw = [0; 8];
        let raw = &mut raw[..kind.size()];
        raw.copy_from_slice(&self.bytes[start..self.at]);
        if self.big_endian {
            raw.reverse();
        }
        Ok(kind.decode(raw))
    }
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The value of little-endian bytes.
    fn decode(self, raw: &[u8]) -> f64 {
        let bits = raw.iter().rev().fold(0u64, |bits, &byte| bits << 8 | u64::from(byte));
        match self {
            Self::I8 => f64::from(bits as u8 as i8),
            Self::I16 => f64::from(bits as u16 as i16),
            Self::I32 => f64::from(bits as u32 as i32),
            Self::U8 | Self::U16 | Self::U32 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

fn header(bytes: &[u8]) -> Result<Header, String> {
    let mut header = Header { big_endian: false, elements: Vec::new(), end: 0 };
    loop {
        let start = header.end;
        let length = bytes[start..].iter().position(|&b| b == b'\n').ok_or("not a PLY file, or cut off")?;
        header.end = start + length + 1;
        let line =
            std::str::from_utf8(&bytes[start..start + length]).map_err(|_| "the header is not text")?;
        if start == 0 && line.trim_end() != "ply" {
            return Err("not a PLY file".to_owned());
        }
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["end_header"] => return Ok(header),
            ["format", encoding, ..] => header.big_endian = is_big_endian(encoding)?,
            ["element", name, count] => header.elements.push(element(bytes, name, count)?),
            ["property", ..] => {
                let property = property(&words[1..]).ok_or_else(|| format!("'{line}' is not understood"))?;
                header.elements.last_mut().ok_or("a property before any element")?.properties.push(property);
            }
            _ => {}
        }
    }
}

fn is_big_endian(encoding: &str) -> Result<bool, String> {
    match encoding {
        "binary_little_endian" => Ok(false),
        "binary_big_endian" => Ok(true),
        other => Err(format!("{other}: only binary PLY can be dug; convert the tile first")),
    }
}

/// An element whose count is a slice of `bytes`.
fn element(bytes: &[u8], name: &str, count: &str) -> Result<Element, String> {
    let start = count.as_ptr().addr() - bytes.as_ptr().addr();
    let number = count.parse().map_err(|_| format!("element {name}: '{count}' is not a count"))?;
    Ok(Element {
        name: name.to_owned(),
        count: number,
        count_digits: start..start + count.len(),
        properties: Vec::new(),
    })
}

fn property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", length, value, name] => Some(Property {
            name: (*name).to_owned(),
            length: Some(Scalar::named(length)?),
            value: Scalar::named(value)?,
        }),
        [value, name] => {
            Some(Property { name: (*name).to_owned(), length: None, value: Scalar::named(value)? })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(big_endian: bool) -> Vec<u8> {
        let encoding = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = format!(
            "ply\r\nformat {encoding} 1.0\ncomment kept\nelement vertex 3\nproperty float x\nproperty double y\n\
             property short z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_index\n\
             property list uchar float texcoord\nelement camera 1\nproperty int n\nend_header\n"
        )
        .into_bytes();
        let mut push = |mut raw: Vec<u8>| {
            if big_endian {
                raw.reverse();
            }
            bytes.extend(raw);
        };
        for [x, y, z] in [[0i16, 0, 0], [3, 0, -5], [0, 6, 0]] {
            push(f32::from(x).to_le_bytes().into());
            push(f64::from(y).to_le_bytes().into());
            push(z.to_le_bytes().into());
            push(vec![200]);
        }
        for corners in [[0i32, 1, 2], [2, 1, 0]] {
            push(vec![3]);
            corners.iter().for_each(|c| push(c.to_le_bytes().into()));
            push(vec![1]);
            push(0.5f32.to_le_bytes().into());
        }
        push(77i32.to_le_bytes().into());
        bytes
    }

    #[test]
    fn reads_both_byte_orders_and_takes_out_rows() {
        for big_endian in [false, true] {
            let bytes = tile(big_endian);
            let faces = read(&bytes).unwrap();
            assert_eq!(faces.positions[1], [3.0, 0.0, -5.0]);
            assert_eq!(faces.corners, [0, 1, 2, 2, 1, 0]);
            assert_eq!(faces.plan_area(0), 9.0);
            assert_eq!(faces.without(&bytes, |_| false), bytes);
            let left = faces.without(&bytes, |f| f == 0);
            assert_eq!(left.len(), bytes.len() - 18);
            assert_eq!(read(&left).unwrap().corners, [2, 1, 0]);
        }
    }

    #[test]
    fn broken_files_are_refused_with_the_cause() {
        let whole = tile(false);
        let cases: [(&[u8], &str); 4] = [
            (b"solid", "cut off"),
            (b"obj\n", "not a PLY"),
            (b"ply\nformat ascii 1.0\n", "only binary"),
            (&whole[..whole.len() - 9], "ends early"),
        ];
        for (bytes, cause) in cases {
            let problem = read(bytes).unwrap_err();
            assert!(problem.contains(cause), "{problem}");
        }
    }
}
