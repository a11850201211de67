//! The container of binary glTF.

use std::ops::Range;

/// Where the chunks lie in the file.
pub(super) struct Chunks {
    /// The document; programs fill it up with blanks, or wrongly with NULs.
    pub json: Range<usize>,
    /// The first buffer's content.
    pub binary: Option<Range<usize>>,
}

/// The chunks of a file that starts with `glTF`; those of unknown types are passed over, as the specification asks.
pub(super) fn chunks(bytes: &[u8]) -> Result<Chunks, String> {
    let number = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let (Some(version), Some(length)) = (number(4), number(8)) else {
        return Err("the header is cut off".to_owned());
    };
    if version != 2 {
        return Err(format!("the container's version is {version}, and 2 is expected"));
    }
    let (mut json, mut binary) = (None, None);
    let (mut at, end) = (12, length.min(bytes.len()));
    while let (Some(size), Some(kind)) = (number(at), bytes.get(at + 4..at + 8)) {
        let content = at + 8..at + 8 + size;
        if at >= end {
            break;
        }
        if content.end > bytes.len() {
            return Err(format!("a chunk of {size} bytes is announced and {} are there", bytes.len() - content.start));
        }
        at = content.end;
        match kind {
            b"JSON" => _ = json.get_or_insert(content),
            b"BIN\0" => _ = binary.get_or_insert(content),
            _ => {}
        }
    }
    json.map(|json| Chunks { json, binary }).ok_or_else(|| "there is no JSON chunk".to_owned())
}
