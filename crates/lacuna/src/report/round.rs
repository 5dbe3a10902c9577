//! Numbers of the report, rounded when they are written: metres to millimetres, square metres to square millimetres.
//!
//! Rounding keeps the file readable and its bytes equal where two machines differ in the last bits. A number that is
//! not finite is written as `null` and read as NaN.

use serde::{Deserialize, Deserializer, Serializer};

/// The nearest number with `digits` decimals (at most 9); numbers that are not finite stay as they are.
#[must_use]
pub(crate) fn round_to(value: f64, digits: u32) -> f64 {
    let scale = 10f64.powi(digits.min(9).cast_signed());
    let rounded = (value * scale).round() / scale;
    // Too large to hold the decimals (or not finite): there is nothing to round. `+ 0.0` turns -0 into 0.
    if (value * scale).abs() < 9.0e15 { rounded + 0.0 } else { value }
}

fn write<S: Serializer>(value: f64, digits: u32, serializer: S) -> Result<S::Ok, S::Error> {
    if value.is_finite() {
        serializer.serialize_f64(round_to(value, digits))
    } else {
        serializer.serialize_none()
    }
}

fn read<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

macro_rules! rounded {
    ($(#[$doc:meta])* $name:ident, $digits:literal) => {
        $(#[$doc])*
        pub(crate) mod $name {
            use super::{Deserializer, Serializer};

            pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
                super::write(*value, $digits, serializer)
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
                super::read(deserializer)
            }
        }
    };
}

rounded!(
    /// Metres and seconds: 3 decimals.
    milli,
    3
);
rounded!(
    /// Square metres, and lengths that prove a promise: 6 decimals.
    micro,
    6
);

macro_rules! rounded_option {
    ($(#[$doc:meta])* $name:ident, $digits:literal) => {
        $(#[$doc])*
        pub(crate) mod $name {
            use super::{Deserialize, Deserializer, Serializer};

            pub(crate) fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
                super::write(value.unwrap_or(f64::NAN), $digits, serializer)
            }

            pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
                Option::<f64>::deserialize(deserializer)
            }
        }
    };
}

rounded_option!(
    /// Metres that may be missing: 3 decimals.
    milli_option,
    3
);
rounded_option!(
    /// Shares and qualities that may be missing: 6 decimals.
    micro_option,
    6
);

/// A place in plan: both coordinates to 3 decimals.
pub(crate) mod place {
    use super::{Deserialize, Deserializer, Serializer, round_to};
    use serde::Serialize;

    pub(crate) fn serialize<S: Serializer>(value: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
        value.map(|v| v.is_finite().then(|| round_to(v, 3))).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
        Ok(<[Option<f64>; 2]>::deserialize(deserializer)?.map(|v| v.unwrap_or(f64::NAN)))
    }
}

#[cfg(test)]
mod tests {
    use super::round_to;

    #[test]
    fn rounds_to_the_nearest_decimal() {
        for (value, digits, expected) in [
            (1.23456, 3, 1.235),
            (-1.23456, 3, -1.235),
            (-0.000_4, 3, 0.0),
            (512_345.678_949, 3, 512_345.679),
            (1e300, 3, 1e300),
            (2.0, 0, 2.0),
        ] {
            assert_eq!(round_to(value, digits).to_bits(), f64::to_bits(expected), "{value} to {digits}");
        }
        assert!(round_to(f64::NAN, 3).is_nan());
    }
}
