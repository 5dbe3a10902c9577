//! Checked access to accessors: every offset, stride, count and sparse index is compared with the bytes that are there.

use super::buffer::Buffers;
use super::document::{Accessor, Document, Sparse};
use super::{element, json_fault};
use crate::fault::Fault;

/// Largest stride that the specification allows, bytes.
const MAX_STRIDE: u64 = 252;

/// Type of one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u64, pointer: &str) -> Result<Self, Fault> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(json_fault(pointer, format!("componentType {other} is none of glTF's"))),
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value at the front of `bytes` as f32, decoded as the specification says (section 3.11).
    fn decode(self, bytes: &[u8], normalized: bool) -> f32 {
        let value = match self {
            Self::F32 => return f32::from_bits(little_endian(bytes, 4)),
            Self::I8 => f32::from(little_endian(bytes, 1) as i8),
            Self::U8 => f32::from(little_endian(bytes, 1) as u8),
            Self::I16 => f32::from(little_endian(bytes, 2) as i16),
            Self::U16 => f32::from(little_endian(bytes, 2) as u16),
            Self::U32 => little_endian(bytes, 4) as f32,
        };
        match (normalized, self) {
            (true, Self::I8) => (value / 127.0).max(-1.0),
            (true, Self::U8) => value / 255.0,
            (true, Self::I16) => (value / 32_767.0).max(-1.0),
            (true, Self::U16) => value / 65_535.0,
            _ => value,
        }
    }
}

fn little_endian(bytes: &[u8], count: usize) -> u32 {
    bytes.iter().take(count).rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte))
}

/// An accessor whose every element is known to lie in its bytes.
#[derive(Clone, Debug)]
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub(super) count: usize,
    /// Type of a component.
    pub(super) component: Component,
    /// Components of an element.
    pub(super) width: usize,
    normalized: bool,
    stride: usize,
    /// From the first element on; `None` means zeros.
    bytes: Option<&'a [u8]>,
    /// Elements that a sparse accessor replaces, sorted by index.
    replaced: Vec<(u32, &'a [u8])>,
}

impl<'a> Elements<'a> {
    /// The accessor at `index`.
    ///
    /// # Errors
    /// Whatever does not fit the bytes: offsets, stride, count, sparse indices; an unknown type.
    pub(super) fn open(document: &Document, buffers: &'a Buffers<'_>, index: u64) -> Result<Self, Fault> {
        let accessor = element(&document.accessors, index, "accessor", "/accessors")?;
        let pointer = format!("/accessors/{index}");
        let component = Component::from_code(accessor.component_type, &pointer)?;
        let width = width_of(&accessor.kind, &pointer)?;
        let layout = Layout { size: component.bytes() * width, count: accessor.count, pointer: &pointer };
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = layout.slice(document, buffers, view, accessor.byte_offset)?;
                (Some(bytes), stride)
            }
            None => (None, layout.size),
        };
        let replaced = match &accessor.sparse {
            Some(sparse) => replaced_elements(document, buffers, accessor, sparse, &layout)?,
            None => Vec::new(),
        };
        let count = layout.checked_count()?;
        Ok(Self { count, component, width, normalized: accessor.normalized, stride, bytes, replaced })
    }

    /// The first three components of an element (zero where it has fewer).
    pub(super) fn vec3(&self, at: usize) -> [f32; 3] {
        let [x, y, z, _] = self.vec4(at, 0.0);
        [x, y, z]
    }

    /// Four components of an element; `missing` where it has fewer.
    pub(super) fn vec4(&self, at: usize, missing: f32) -> [f32; 4] {
        let bytes = self.element(at);
        let mut values = [missing; 4];
        for (k, value) in values.iter_mut().enumerate().take(self.width) {
            let component = bytes.get(k * self.component.bytes()..).unwrap_or(&[]);
            *value = self.component.decode(component, self.normalized);
        }
        values
    }

    /// An element of one unsigned component.
    pub(super) fn index(&self, at: usize) -> u32 {
        little_endian(self.element(at), self.component.bytes())
    }

    /// The bytes of an element; nothing where the accessor is all zeros.
    fn element(&self, at: usize) -> &'a [u8] {
        if let Ok(found) = self.replaced.binary_search_by_key(&at, |&(index, _)| index as usize) {
            return self.replaced[found].1;
        }
        self.bytes.and_then(|bytes| bytes.get(at * self.stride..)).unwrap_or(&[])
    }
}

fn width_of(kind: &str, pointer: &str) -> Result<usize, Fault> {
    match kind {
        "SCALAR" => Ok(1),
        "VEC2" => Ok(2),
        "VEC3" => Ok(3),
        "VEC4" => Ok(4),
        other => Err(json_fault(pointer, format!("type {} where a vector belongs", other.escape_debug()))),
    }
}

/// What has to fit into a buffer view.
struct Layout<'a> {
    size: usize,
    count: u64,
    pointer: &'a str,
}

impl Layout<'_> {
    fn checked_count(&self) -> Result<usize, Fault> {
        // Vertex ids are u32.
        let count = u32::try_from(self.count).ok().and_then(|count| usize::try_from(count).ok());
        count.ok_or_else(|| json_fault(self.pointer, format!("count {} is too large", self.count)))
    }

    /// The bytes from the first element on, and the distance between elements.
    fn slice<'b>(
        &self,
        document: &Document,
        buffers: &'b Buffers<'_>,
        view: u64,
        offset: u64,
    ) -> Result<(&'b [u8], usize), Fault> {
        let description = element(&document.buffer_views, view, "bufferView", self.pointer)?;
        let bytes = view_bytes(document, buffers, view)?;
        let stride = self.stride(description.byte_stride)?;
        let last = self
            .count
            .checked_sub(1)
            .map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(self.size as u64));
        let end = last.and_then(|last| offset.checked_add(last));
        match end {
            Some(end) if end <= bytes.len() as u64 => Ok((&bytes[offset as usize..], stride as usize)),
            _ => Err(json_fault(
                self.pointer,
                format!(
                    "{} elements from byte {offset} with stride {stride} do not fit the {} bytes of bufferView {view}",
                    self.count,
                    bytes.len()
                ),
            )),
        }
    }

    fn stride(&self, written: Option<u64>) -> Result<u64, Fault> {
        match written {
            None => Ok(self.size as u64),
            Some(stride) if (self.size as u64..=MAX_STRIDE).contains(&stride) => Ok(stride),
            Some(stride) => Err(json_fault(
                self.pointer,
                format!("byteStride {stride} is not between {} and {MAX_STRIDE}", self.size),
            )),
        }
    }
}

fn view_bytes<'b>(document: &Document, buffers: &'b Buffers<'_>, view: u64) -> Result<&'b [u8], Fault> {
    let pointer = format!("/bufferViews/{view}");
    let description = element(&document.buffer_views, view, "bufferView", "/accessors")?;
    let buffer = element(buffers, description.buffer, "buffer", &pointer)?;
    let end = description.byte_offset.checked_add(description.byte_length);
    match end {
        Some(end) if end <= buffer.len() as u64 => {
            Ok(&buffer[description.byte_offset as usize..end as usize])
        }
        _ => Err(json_fault(
            pointer,
            format!(
                "{} bytes from byte {} do not fit the {} bytes of buffer {}",
                description.byte_length,
                description.byte_offset,
                buffer.len(),
                description.buffer
            ),
        )),
    }
}

fn replaced_elements<'b>(
    document: &Document,
    buffers: &'b Buffers<'_>,
    accessor: &Accessor,
    sparse: &Sparse,
    layout: &Layout<'_>,
) -> Result<Vec<(u32, &'b [u8])>, Fault> {
    let component = Component::from_code(sparse.indices.component_type, layout.pointer)?;
    if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
        return Err(json_fault(layout.pointer, "sparse indices are not unsigned integers"));
    }
    let indices = Layout { size: component.bytes(), count: sparse.count, pointer: layout.pointer };
    let values = Layout { size: layout.size, count: sparse.count, pointer: layout.pointer };
    let (keys, key_stride) =
        indices.slice(document, buffers, sparse.indices.buffer_view, sparse.indices.byte_offset)?;
    let (bytes, value_stride) =
        values.slice(document, buffers, sparse.values.buffer_view, sparse.values.byte_offset)?;
    let mut replaced = Vec::with_capacity(indices.checked_count()?);
    for k in 0..indices.checked_count()? {
        let index = little_endian(&keys[k * key_stride..], component.bytes());
        let ascending = replaced.last().is_none_or(|&(last, _)| last < index);
        if u64::from(index) >= accessor.count || !ascending {
            return Err(json_fault(layout.pointer, format!("sparse index {index} is out of range or order")));
        }
        replaced.push((index, &bytes[k * value_stride..]));
    }
    Ok(replaced)
}
