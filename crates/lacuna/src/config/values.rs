//! Values of single flags, with errors that say what was expected.

use super::memory::MemoryLimit;
use std::path::PathBuf;

/// Value of `--area`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AreaArgument {
    /// `cells`.
    Cells,
    /// `box`.
    Box,
    /// A GeoJSON file.
    File(PathBuf),
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!(
            "`{}` is no number; write it without a unit, such as 250 or 0.5",
            text.escape_debug()
        )),
    }
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 => Ok(value),
        _ => Err("must be above 0".to_owned()),
    }
}

/// A number of 0 or above.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value >= 0.0 => Ok(value),
        _ => Err("must not be negative".to_owned()),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(number).collect()
}

/// `X,Y`.
pub(crate) fn pair(text: &str) -> Result<[f64; 2], String> {
    match numbers(text)?[..] {
        [x, y] => Ok([x, y]),
        _ => Err("expected two numbers, X,Y, such as 84512.5,447233".to_owned()),
    }
}

/// `X,Y` or `X,Y,Z`.
pub(crate) fn pair_or_triple(text: &str) -> Result<[f64; 3], String> {
    match numbers(text)?[..] {
        [x, y] => Ok([x, y, 0.0]),
        [x, y, z] => Ok([x, y, z]),
        _ => Err("expected X,Y or X,Y,Z, such as 84000,447000,0".to_owned()),
    }
}

/// `cells`, `box` or a file name.
pub(crate) fn area(text: &str) -> Result<AreaArgument, String> {
    match text {
        "cells" => Ok(AreaArgument::Cells),
        "box" => Ok(AreaArgument::Box),
        _ if text.contains(['.', '/', '\\']) => Ok(AreaArgument::File(PathBuf::from(text))),
        _ => Err("expected cells, box, or the name of a GeoJSON file such as contract.geojson".to_owned()),
    }
}

/// `512MiB`, `6GB` or `50%`.
pub(crate) fn memory(text: &str) -> Result<MemoryLimit, String> {
    text.parse()
}
