//! The eight number types of PLY.

/// A number type. Every value of each fits an f64 exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// Byte order of a binary body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Endian {
    Little,
    Big,
}

const NAMES: [(&str, Scalar); 16] = [
    ("char", Scalar::I8),
    ("uchar", Scalar::U8),
    ("short", Scalar::I16),
    ("ushort", Scalar::U16),
    ("int", Scalar::I32),
    ("uint", Scalar::U32),
    ("float", Scalar::F32),
    ("double", Scalar::F64),
    ("int8", Scalar::I8),
    ("uint8", Scalar::U8),
    ("int16", Scalar::I16),
    ("uint16", Scalar::U16),
    ("int32", Scalar::I32),
    ("uint32", Scalar::U32),
    ("float32", Scalar::F32),
    ("float64", Scalar::F64),
];

impl Scalar {
    /// The type of a name, old or new spelling.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        NAMES.iter().find(|(known, _)| *known == name).map(|(_, scalar)| *scalar)
    }

    /// The old spelling of the name.
    pub(crate) fn name(self) -> &'static str {
        NAMES.iter().find(|(_, scalar)| *scalar == self).map_or("", |(name, _)| name)
    }

    /// Bytes of one value.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// True for float and double.
    pub(crate) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Largest whole number up to which every whole number can be stored.
    pub(crate) fn largest_index(self) -> u64 {
        match self {
            Self::I8 => 127,
            Self::U8 => 255,
            Self::I16 => 32_767,
            Self::U16 => 65_535,
            Self::I32 => 2_147_483_647,
            Self::U32 => 4_294_967_295,
            Self::F32 => 1 << 24,
            Self::F64 => 1 << 53,
        }
    }

    /// What stands for "all of it" in a colour channel of this type: 1 for floats, else the largest number.
    pub(crate) fn full_channel(self) -> f64 {
        if self.is_float() { 1.0 } else { self.largest_index() as f64 }
    }

    /// The value at the start of `bytes`, which must hold `size()` bytes.
    pub(crate) fn decode(self, bytes: &[u8], endian: Endian) -> f64 {
        match (self, endian) {
            (Self::I8, _) => f64::from(bytes[0].cast_signed()),
            (Self::U8, _) => f64::from(bytes[0]),
            (Self::I16, Endian::Little) => i16::from_le_bytes(word(bytes)).into(),
            (Self::I16, Endian::Big) => i16::from_be_bytes(word(bytes)).into(),
            (Self::U16, Endian::Little) => u16::from_le_bytes(word(bytes)).into(),
            (Self::U16, Endian::Big) => u16::from_be_bytes(word(bytes)).into(),
            (Self::I32, Endian::Little) => i32::from_le_bytes(word(bytes)).into(),
            (Self::I32, Endian::Big) => i32::from_be_bytes(word(bytes)).into(),
            (Self::U32, Endian::Little) => u32::from_le_bytes(word(bytes)).into(),
            (Self::U32, Endian::Big) => u32::from_be_bytes(word(bytes)).into(),
            (Self::F32, Endian::Little) => f32::from_le_bytes(word(bytes)).into(),
            (Self::F32, Endian::Big) => f32::from_be_bytes(word(bytes)).into(),
            (Self::F64, Endian::Little) => f64::from_le_bytes(word(bytes)),
            (Self::F64, Endian::Big) => f64::from_be_bytes(word(bytes)),
        }
    }

    /// Appends `value`, which the type must be able to hold (else the nearest one it holds), to `out`.
    pub(crate) fn encode(self, value: f64, endian: Endian, out: &mut Vec<u8>) {
        let start = out.len();
        match self {
            Self::I8 => out.extend((value as i8).to_le_bytes()),
            Self::U8 => out.extend((value as u8).to_le_bytes()),
            Self::I16 => out.extend((value as i16).to_le_bytes()),
            Self::U16 => out.extend((value as u16).to_le_bytes()),
            Self::I32 => out.extend((value as i32).to_le_bytes()),
            Self::U32 => out.extend((value as u32).to_le_bytes()),
            Self::F32 => out.extend((value as f32).to_le_bytes()),
            Self::F64 => out.extend(value.to_le_bytes()),
        }
        if endian == Endian::Big {
            out[start..].reverse();
        }
    }

    /// The number in a text token: floats rounded once to their own type; `None` if it isn't a number.
    pub(crate) fn parse(self, token: &[u8]) -> Option<f64> {
        match self {
            Self::F32 => fast_float2::parse::<f32, _>(token).ok().map(f64::from),
            _ => fast_float2::parse::<f64, _>(token).ok(),
        }
    }

    /// `value` as text: the shortest decimal that comes back as the same bits of this type.
    pub(crate) fn print(self, value: f64) -> String {
        match self {
            Self::F32 => (value as f32).to_string(),
            Self::F64 => value.to_string(),
            _ => (value as i64).to_string(),
        }
    }
}

/// The first `N` bytes.
pub(crate) fn word<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut word = [0; N];
    word.copy_from_slice(&bytes[..N]);
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_in_both_byte_orders_and_as_text() {
        let cases = [
            (Scalar::I8, -7.0),
            (Scalar::U8, 255.0),
            (Scalar::I16, -30_000.0),
            (Scalar::U16, 65_535.0),
            (Scalar::I32, -2_147_483_648.0),
            (Scalar::U32, 4_294_967_295.0),
            (Scalar::F32, f64::from(0.1_f32)),
            (Scalar::F64, 0.1),
            (Scalar::F64, 497_429.521_3),
        ];
        for (scalar, value) in cases {
            for endian in [Endian::Little, Endian::Big] {
                let mut bytes = Vec::new();
                scalar.encode(value, endian, &mut bytes);
                assert_eq!(bytes.len(), scalar.size());
                assert_eq!(scalar.decode(&bytes, endian), value, "{scalar:?} {endian:?}");
            }
            assert_eq!(scalar.parse(scalar.print(value).as_bytes()), Some(value), "{scalar:?} as text");
        }
    }

    #[test]
    fn numbers_in_text() {
        for (token, want) in [("+1", 1.0), ("2.", 2.0), (".5", 0.5), ("1e2", 100.0), ("2.e1", 20.0)] {
            assert_eq!(Scalar::F64.parse(token.as_bytes()), Some(want), "{token}");
        }
        assert_eq!(Scalar::F64.parse(b"1e999"), Some(f64::INFINITY));
        assert!(Scalar::F32.parse(b"nan").is_some_and(f64::is_nan));
        assert_eq!(Scalar::F64.parse(b"1x"), None);
        assert_eq!(Scalar::I32.parse(b""), None);
    }
}
