//! The one byte form of a JSON value, for digests and keys.
//!
//! Each value begins with a letter for its type; texts and lists carry their length (u64, little endian);
//! object members come in the order of their names; floats are written by their bits, every NaN as one.
//! The order in which a map was filled, white space and the spelling of a number leave no trace.

use serde_json::Value;

/// The canonical bytes of `value`.
pub fn json(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(value, &mut bytes);
    bytes
}

fn write(value: &Value, bytes: &mut Vec<u8>) {
    match value {
        Value::Null => bytes.push(b'n'),
        Value::Bool(false) => bytes.push(b'f'),
        Value::Bool(true) => bytes.push(b't'),
        Value::Number(number) => {
            if let Some(whole) = number.as_i128() {
                bytes.push(b'i');
                bytes.extend(whole.to_le_bytes());
            } else {
                bytes.push(b'd');
                bytes.extend(number.as_f64().unwrap_or(f64::NAN).to_bits().to_le_bytes());
            }
        }
        Value::String(text) => write_text(text, bytes),
        Value::Array(values) => {
            bytes.push(b'[');
            bytes.extend((values.len() as u64).to_le_bytes());
            for value in values {
                write(value, bytes);
            }
        }
        Value::Object(members) => {
            let mut sorted: Vec<_> = members.iter().collect();
            sorted.sort_by(|a, b| a.0.cmp(b.0));
            bytes.push(b'{');
            bytes.extend((sorted.len() as u64).to_le_bytes());
            for (name, value) in sorted {
                write_text(name, bytes);
                write(value, bytes);
            }
        }
    }
}

fn write_text(text: &str, bytes: &mut Vec<u8>) {
    bytes.push(b's');
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
}
