//! Arrays from a NumPy archive.

use anyhow::{Context, Result, bail};
use std::path::Path;

/// A table of numbers, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Its numbers.
    pub values: Vec<f64>,
}

/// Reads the member `name` (a table of integers or floats, in C order) of an `.npz` file: a ZIP archive, deflated or stored.
///
/// # Errors
/// A file that can't be read, no such member, another kind of array.
pub fn read_array(path: &Path, name: &str) -> Result<Array> {
    let file = || path.display().to_string();
    let bytes = std::fs::read(path).with_context(file)?;
    let array = member(&bytes, name).with_context(|| format!("{}: no member {name}", file()))?;
    parse(&array).with_context(|| format!("{}: {name} is not a plain table of numbers", file()))
}

fn parse(array: &[u8]) -> Option<Array> {
    let header_bytes = usize::from(u16::from_le_bytes([*array.get(8)?, *array.get(9)?]));
    let header = std::str::from_utf8(array.get(10..10 + header_bytes)?).ok()?;
    let shape = header.split_once("'shape': (")?.1.split_once(')')?.0;
    let mut sizes = shape.split(',').filter_map(|s| s.trim().parse::<usize>().ok());
    let (rows, columns) = (sizes.next()?, sizes.next()?);
    if header.contains("'fortran_order': True") {
        return None;
    }
    let data = array.get(10 + header_bytes..)?;
    let kind = header.split_once("'descr': '")?.1.split_once('\'')?.0;
    let values: Vec<f64> = match kind {
        "<i2" => numbers(data, |b| f64::from(i16::from_le_bytes(b))),
        "<i4" => numbers(data, |b| f64::from(i32::from_le_bytes(b))),
        "<u4" => numbers(data, |b| f64::from(u32::from_le_bytes(b))),
        "<i8" => numbers(data, |b| i64::from_le_bytes(b) as f64),
        "<f4" => numbers(data, |b| f64::from(f32::from_le_bytes(b))),
        "<f8" => numbers(data, f64::from_le_bytes),
        _ => return None,
    };
    (values.len() == rows * columns).then_some(Array { rows, columns, values })
}

fn numbers<const N: usize>(data: &[u8], number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    data.as_chunks::<N>().0.iter().map(|b| number(*b)).collect()
}

/// The bytes of a member of a ZIP archive, found by the archive's own list at its end.
fn member(zip: &[u8], name: &str) -> Result<Vec<u8>> {
    let u16_at = |at: usize| zip.get(at..at + 2).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])));
    let u32_at =
        |at: usize| zip.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let find = || -> Option<(usize, usize, usize)> {
        let end = zip.windows(4).rposition(|w| w == b"PK\x05\x06")?;
        let mut at = u32_at(end + 16)?;
        while zip.get(at..at + 4)? == b"PK\x01\x02" {
            let [name_bytes, extra, comment] = [u16_at(at + 28)?, u16_at(at + 30)?, u16_at(at + 32)?];
            if zip.get(at + 46..at + 46 + name_bytes)? == name.as_bytes() {
                let local = u32_at(at + 42)?;
                let data = local + 30 + u16_at(local + 26)? + u16_at(local + 28)?;
                return Some((data, u32_at(at + 20)?, u16_at(at + 10)?));
            }
            at += 46 + name_bytes + extra + comment;
        }
        None
    };
    let Some((start, length, method)) = find() else { bail!("it is not in the archive's list") };
    let Some(data) = zip.get(start..start + length) else { bail!("the archive is cut short") };
    match method {
        0 => Ok(data.to_vec()),
        8 => miniz_oxide::inflate::decompress_to_vec_with_limit(data, 1 << 28)
            .map_err(|e| anyhow::anyhow!("it can't be inflated: {e}")),
        other => bail!("compression {other} is unknown"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes of an array file.
    fn file(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
        let mut array = b"\x93NUMPY\x01\x00".to_vec();
        array.extend((header.len() as u16).to_le_bytes());
        array.extend(header.as_bytes());
        array.extend(data);
        array
    }

    #[test]
    fn tables_of_numbers_are_read_and_others_are_not() {
        let bytes: Vec<u8> = [1i16, -2, 300, 4].iter().flat_map(|k| k.to_le_bytes()).collect();
        let array = parse(&file("<i2", "2, 2", &bytes)).expect("a table");
        assert_eq!((array.rows, array.columns, array.values), (2, 2, vec![1.0, -2.0, 300.0, 4.0]));
        let floats: Vec<u8> = [0.5f64, -1.5].iter().flat_map(|k| k.to_le_bytes()).collect();
        assert_eq!(parse(&file("<f8", "1, 2", &floats)).map(|a| a.values), Some(vec![0.5, -1.5]));
        for bad in
            [file("<c8", "2, 2", &bytes), file("<i2", "2, 3", &bytes), file("<i2", "4,", &bytes), vec![0; 4]]
        {
            assert_eq!(parse(&bad), None);
        }
    }
}
