//! Where a JPEG picture ends: telephones and cameras put films, depth maps and further pictures behind it.

/// Bytes of the first picture in `bytes`, which begin with it; `None` where its end-of-image marker is missing.
///
/// Walks from marker to marker (ITU-T T.81, B.1): a segment brings its length, so that the thumbnail inside one does not
/// count; within the coded data 0xFF is followed by 0 or a restart marker.
pub(super) fn jpeg_end(bytes: &[u8]) -> Option<usize> {
    let mut at = 2;
    loop {
        at += bytes.get(at..)?.iter().position(|b| *b == 0xFF)?;
        let marker = *bytes.get(at + 1)?;
        match marker {
            0xD9 => return Some(at + 2),
            // Filling.
            0xFF => at += 1,
            // Coded data, restarts, markers without a length.
            0x00 | 0x01 | 0xD0..=0xD8 => at += 2,
            _ => {
                let length = bytes.get(at + 2..at + 4)?;
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_and_coded_data_do_not_end_it() {
        let whole = b"\xFF\xD8\xFF\xE1\x00\x06\xFF\xD8\xFF\xD9\xFF\xDA\x00\x03\x01ab\xFF\x00c\xFF\xD0d\xFF\xFF\xD9";
        assert_eq!(jpeg_end(whole), Some(whole.len()));
        assert_eq!(jpeg_end(&[whole, &b"\0\0\0\x18ftypmp42\xFF\xD8\xFF\xD9"[..]].concat()), Some(whole.len()));
        for keep in 0..whole.len() {
            assert_eq!(jpeg_end(&whole[..keep]), None, "cut to {keep}");
        }
    }
}
