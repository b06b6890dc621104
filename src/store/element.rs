//! The types a stored array can hold.

use serde::{Deserialize, Serialize};
use zarrs::array::builder::ArrayBuilderFillValue;

/// Data type of a stored array, named as in Zarr.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dtype {
    /// 8-bit unsigned.
    Uint8,
    /// 16-bit unsigned.
    Uint16,
    /// 32-bit unsigned.
    Uint32,
    /// 64-bit unsigned.
    Uint64,
    /// 8-bit signed.
    Int8,
    /// 16-bit signed.
    Int16,
    /// 32-bit signed.
    Int32,
    /// 64-bit signed.
    Int64,
    /// Single precision.
    Float32,
    /// Double precision.
    Float64,
}

impl Dtype {
    /// Bytes of one element.
    pub fn bytes(self) -> usize {
        match self {
            Self::Uint8 | Self::Int8 => 1,
            Self::Uint16 | Self::Int16 => 2,
            Self::Uint32 | Self::Int32 | Self::Float32 => 4,
            Self::Uint64 | Self::Int64 | Self::Float64 => 8,
        }
    }

    /// The name that Zarr uses, such as `float32`.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Uint8 => "uint8",
            Self::Uint16 => "uint16",
            Self::Uint32 => "uint32",
            Self::Uint64 => "uint64",
            Self::Int8 => "int8",
            Self::Int16 => "int16",
            Self::Int32 => "int32",
            Self::Int64 => "int64",
            Self::Float32 => "float32",
            Self::Float64 => "float64",
        }
    }
}

/// A number that arrays in the store are made of.
pub trait Element:
    Copy + Send + Sync + PartialEq + std::fmt::Debug + zarrs::array::ElementOwned + Into<ArrayBuilderFillValue> + 'static
{
    /// Its data type.
    const DTYPE: Dtype;
    /// Value of cells never written: NaN for floats, 0 for integers.
    const FILL: Self;
    /// The same number with its one bit pattern: every NaN becomes the one quiet NaN.
    #[must_use]
    fn canonical(self) -> Self;
    /// Appends the canonical values, little endian.
    fn extend_le(values: &[Self], bytes: &mut Vec<u8>);
}

macro_rules! element {
    ($type:ty, $dtype:ident, $fill:expr, $value:ident => $canonical:expr) => {
        impl Element for $type {
            const DTYPE: Dtype = Dtype::$dtype;
            const FILL: Self = $fill;

            #[inline]
            fn canonical(self) -> Self {
                let $value = self;
                $canonical
            }

            fn extend_le(values: &[Self], bytes: &mut Vec<u8>) {
                let start = bytes.len();
                bytes.resize(start + size_of_val(values), 0);
                for (cell, value) in bytes[start..].chunks_exact_mut(size_of::<Self>()).zip(values) {
                    cell.copy_from_slice(&value.canonical().to_le_bytes());
                }
            }
        }
    };
}

element!(u8, Uint8, 0, v => v);
element!(u16, Uint16, 0, v => v);
element!(u32, Uint32, 0, v => v);
element!(u64, Uint64, 0, v => v);
element!(i8, Int8, 0, v => v);
element!(i16, Int16, 0, v => v);
element!(i32, Int32, 0, v => v);
element!(i64, Int64, 0, v => v);
element!(f32, Float32, f32::NAN, v => if v.is_nan() { f32::NAN } else { v });
element!(f64, Float64, f64::NAN, v => if v.is_nan() { f64::NAN } else { v });
