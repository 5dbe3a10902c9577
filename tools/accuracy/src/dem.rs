//! An elevation raster.

use crate::npz::{Array, read_array};
use anyhow::{Result, ensure};
use std::path::Path;

/// Heights on a raster.
#[derive(Clone, Debug, PartialEq)]
pub struct Elevation {
    raster: Array,
}

impl Elevation {
    /// Reads the member `name` of an `.npz` file.
    ///
    /// # Errors
    /// As [`read_array`]; an empty raster.
    pub fn read(path: &Path, name: &str) -> Result<Self> {
        let raster = read_array(path, name)?;
        ensure!(!raster.values.is_empty(), "{}: {name} is empty", path.display());
        Ok(Self { raster })
    }

    /// The height at column `x` and row `y`, between pixels bilinear; the edge goes on for ever.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let place = |v: f64, count: usize| {
            let v = v.clamp(0.0, (count - 1) as f64);
            let low = (v.floor() as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), v - low as f64)
        };
        let ((x0, x1, u), (y0, y1, v)) = (place(x, self.raster.columns), place(y, self.raster.rows));
        let pixel = |column: usize, row: usize| self.raster.values[row * self.raster.columns + column];
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        mix(mix(pixel(x0, y0), pixel(x1, y0), u), mix(pixel(x0, y1), pixel(x1, y1), u), v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_between_pixels_are_bilinear_and_the_edge_goes_on() {
        let values = vec![0.0, 10.0, 20.0, 100.0, 110.0, 120.0];
        let raster = Elevation { raster: Array { rows: 2, columns: 3, values } };
        for (x, y, expected) in
            [(0.0, 0.0, 0.0), (1.5, 0.0, 15.0), (1.0, 0.5, 60.0), (2.0, 1.0, 120.0), (-5.0, 9.0, 100.0)]
        {
            assert!((raster.at(x, y) - expected).abs() < 1e-12, "{x}, {y}");
        }
    }
}
