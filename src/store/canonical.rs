//! The one byte form of a value, for digests and keys.
//!
//! It follows the value's JSON form, with every number by its type and bits: each value begins with a letter for its
//! type (`n` null, `t`/`f` truth, `i` whole number as 128 bits, `d` float as the bits of the double, `s` text, `[` list,
//! `{` object); texts, lists and objects carry their length (u64, little endian); object members come in the order of
//! their names. Unlike JSON it tells infinities and NaN (all NaNs as one) from null. The order in which a map was
//! filled, white space and the spelling of a number leave no trace.

use serde::Serialize;
use serde::ser;

use crate::error::{Error, Result};

/// The canonical bytes of `value`.
pub fn bytes<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    value
        .serialize(Writer(&mut bytes))
        .map_err(|Unwritable(cause)| Error::failed(format!("cannot write a value: {cause}")))?;
    Ok(bytes)
}

/// Why a value has no canonical form.
#[derive(Debug)]
struct Unwritable(String);

impl std::fmt::Display for Unwritable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Unwritable {}

impl ser::Error for Unwritable {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

type Written = std::result::Result<(), Unwritable>;

struct Writer<'a>(&'a mut Vec<u8>);

fn text(value: &str, bytes: &mut Vec<u8>) {
    bytes.push(b's');
    bytes.extend((value.len() as u64).to_le_bytes());
    bytes.extend(value.as_bytes());
}

/// A list or an object being gathered; a tagged one (an enum variant with content) is the one member of an object.
struct Gathered<'a> {
    bytes: &'a mut Vec<u8>,
    tag: Option<&'static str>,
    kind: u8,
    key: Vec<u8>,
    items: Vec<(Vec<u8>, Vec<u8>)>,
}

impl Gathered<'_> {
    fn item<T: Serialize + ?Sized>(&mut self, key: Vec<u8>, value: &T) -> Written {
        let mut bytes = Vec::new();
        value.serialize(Writer(&mut bytes))?;
        self.items.push((key, bytes));
        Ok(())
    }

    fn field<T: Serialize + ?Sized>(&mut self, name: &str, value: &T) -> Written {
        self.item(name.as_bytes().to_vec(), value)
    }

    fn close(mut self) -> Written {
        if let Some(tag) = self.tag {
            self.bytes.push(b'{');
            self.bytes.extend(1_u64.to_le_bytes());
            text(tag, self.bytes);
        }
        self.bytes.push(self.kind);
        self.bytes.extend((self.items.len() as u64).to_le_bytes());
        if self.kind == b'{' {
            self.items.sort();
        }
        for (key, value) in self.items {
            if self.kind == b'{' {
                self.bytes.push(b's');
                self.bytes.extend((key.len() as u64).to_le_bytes());
                self.bytes.extend(key);
            }
            self.bytes.extend(value);
        }
        Ok(())
    }
}

impl<'a> Writer<'a> {
    fn gather(self, kind: u8, tag: Option<&'static str>) -> Gathered<'a> {
        Gathered { bytes: self.0, tag, kind, key: Vec::new(), items: Vec::new() }
    }

    fn whole(self, value: i128) -> Written {
        self.0.push(b'i');
        self.0.extend(value.to_le_bytes());
        Ok(())
    }
}

macro_rules! whole {
    ($($method:ident $type:ty),*) => {
        $(fn $method(self, value: $type) -> Written {
            self.whole(value.into())
        })*
    };
}

impl<'a> ser::Serializer for Writer<'a> {
    type Ok = ();
    type Error = Unwritable;
    type SerializeSeq = Gathered<'a>;
    type SerializeTuple = Gathered<'a>;
    type SerializeTupleStruct = Gathered<'a>;
    type SerializeTupleVariant = Gathered<'a>;
    type SerializeMap = Gathered<'a>;
    type SerializeStruct = Gathered<'a>;
    type SerializeStructVariant = Gathered<'a>;

    whole!(serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64, serialize_i128 i128);
    whole!(serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64);

    fn serialize_u128(self, value: u128) -> Written {
        let value = i128::try_from(value).map_err(|_| Unwritable(format!("{value} is too large")))?;
        self.whole(value)
    }
    fn serialize_bool(self, value: bool) -> Written {
        self.0.push(if value { b't' } else { b'f' });
        Ok(())
    }
    fn serialize_f32(self, value: f32) -> Written {
        self.serialize_f64(f64::from(value))
    }
    fn serialize_f64(self, value: f64) -> Written {
        let value = if value.is_nan() { f64::NAN } else { value };
        self.0.push(b'd');
        self.0.extend(value.to_bits().to_le_bytes());
        Ok(())
    }
    fn serialize_char(self, value: char) -> Written {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }
    fn serialize_str(self, value: &str) -> Written {
        text(value, self.0);
        Ok(())
    }
    fn serialize_bytes(self, value: &[u8]) -> Written {
        value.serialize(self)
    }
    fn serialize_none(self) -> Written {
        self.serialize_unit()
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Written {
        value.serialize(self)
    }
    fn serialize_unit(self) -> Written {
        self.0.push(b'n');
        Ok(())
    }
    fn serialize_unit_struct(self, _: &'static str) -> Written {
        self.serialize_unit()
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Written {
        self.serialize_str(variant)
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Written {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Written {
        let mut object = self.gather(b'{', None);
        object.field(variant, value)?;
        object.close()
    }
    fn serialize_seq(self, _: Option<usize>) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'[', None))
    }
    fn serialize_tuple(self, _: usize) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'[', None))
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'[', None))
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'[', Some(variant)))
    }
    fn serialize_map(self, _: Option<usize>) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'{', None))
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'{', None))
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> std::result::Result<Gathered<'a>, Unwritable> {
        Ok(self.gather(b'{', Some(variant)))
    }
}

macro_rules! list {
    ($($compound:ident $method:ident),*) => {
        $(impl ser::$compound for Gathered<'_> {
            type Ok = ();
            type Error = Unwritable;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Written {
                self.item(Vec::new(), value)
            }
            fn end(self) -> Written {
                self.close()
            }
        })*
    };
}
list!(SerializeSeq serialize_element, SerializeTuple serialize_element);
list!(SerializeTupleStruct serialize_field, SerializeTupleVariant serialize_field);

macro_rules! object {
    ($($compound:ident),*) => {
        $(impl ser::$compound for Gathered<'_> {
            type Ok = ();
            type Error = Unwritable;
            fn serialize_field<T: Serialize + ?Sized>(&mut self, name: &'static str, value: &T) -> Written {
                self.field(name, value)
            }
            fn end(self) -> Written {
                self.close()
            }
        })*
    };
}
object!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Gathered<'_> {
    type Ok = ();
    type Error = Unwritable;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Written {
        // As in JSON, keys are texts; others are spelled as JSON spells them.
        let spelled = serde_json::to_string(key).map_err(|e| Unwritable(e.to_string()))?;
        let plain = serde_json::from_str::<String>(&spelled).unwrap_or(spelled);
        self.key = plain.into_bytes();
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Written {
        let key = std::mem::take(&mut self.key);
        self.item(key, value)
    }
    fn end(self) -> Written {
        self.close()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    enum Shape {
        Point,
        Disc(f32),
        Box { high: u8, wide: u8 },
    }

    #[test]
    fn a_struct_and_its_json_have_the_same_bytes() {
        let shapes = [Shape::Point, Shape::Disc(0.5), Shape::Box { high: 1, wide: 2 }];
        assert_eq!(bytes(&shapes).unwrap(), bytes(&serde_json::to_value(&shapes).unwrap()).unwrap());
    }

    #[test]
    fn the_order_of_members_leaves_no_trace() {
        let read = |text: &str| bytes(&serde_json::from_str::<serde_json::Value>(text).unwrap()).unwrap();
        assert_eq!(read(r#"{"a": 1, "b": {"c": 2, "d": 3}}"#), read(r#"{"b": {"d": 3, "c": 2}, "a": 1}"#));
        assert_ne!(read(r#"{"a": 1, "b": 2}"#), read(r#"{"a": 2, "b": 1}"#));
    }

    #[test]
    fn what_differs_has_different_bytes() {
        let all = [
            bytes(&["ab", "cd"]),
            bytes(&["a", "bcd"]),
            bytes(&["abcd"]),
            bytes("abcd"),
            bytes(&1_u8),
            bytes(&1.0_f32),
            bytes(&0.0_f64),
            bytes(&-0.0_f64),
            bytes(&f64::NAN),
            bytes(&f64::INFINITY),
            bytes(&f64::NEG_INFINITY),
            bytes(&None::<u8>),
            bytes::<[u8; 0]>(&[]),
            bytes(&true),
        ];
        let all: std::collections::BTreeSet<Vec<u8>> = all.into_iter().map(|b| b.unwrap()).collect();
        assert_eq!(all.len(), 14);
    }

    #[test]
    fn the_spelling_of_a_number_follows_its_type() {
        assert_eq!(bytes(&1_u8).unwrap(), bytes(&1_i64).unwrap());
        assert_eq!(bytes(&f64::from(0.1_f32)).unwrap(), bytes(&0.1_f32).unwrap());
        assert_eq!(bytes(&-f32::NAN).unwrap(), bytes(&f64::NAN).unwrap());
    }
}
