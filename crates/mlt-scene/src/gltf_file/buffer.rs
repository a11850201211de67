//! Where a glTF file's bytes come from: the GLB chunk, data URIs, files beside it.

use super::CHECK;
use crate::{
    SceneError,
    source::{Source, has_scheme},
};
use gltf::{Document, buffer};

/// The content of every buffer, at least as long as the document says.
pub(super) fn resolve(
    source: &Source,
    document: &Document,
    mut blob: Option<Vec<u8>>,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let fetch = |buffer: buffer::Buffer| {
        let place = format!("buffers[{}]", buffer.index());
        let bytes = match buffer.source() {
            buffer::Source::Bin => {
                blob.take().ok_or_else(|| source.invalid(&place, "there is neither a URI nor a binary chunk", CHECK))?
            }
            buffer::Source::Uri(uri) => read_uri(source, &place, uri)?,
        };
        if bytes.len() < buffer.length() {
            let reason = format!("{} bytes are announced and {} are there", buffer.length(), bytes.len());
            return Err(source.invalid(place, reason, "fetch the file again, it seems cut off"));
        }
        Ok(bytes)
    };
    document.buffers().map(fetch).collect()
}

fn read_uri(source: &Source, place: &str, uri: &str) -> Result<Vec<u8>, SceneError> {
    let malformed = |what: &str| source.invalid(place, format!("the URI is not {what}"), CHECK);
    if let Some(data) = uri.strip_prefix("data:") {
        let (head, body) = data.split_once(',').ok_or_else(|| malformed("a complete data URI"))?;
        let body = percent_decode(body).ok_or_else(|| malformed("percent-encoded as it should be"))?;
        return match head.ends_with(";base64") {
            true => base64_decode(&body).ok_or_else(|| malformed("base64 as it says")),
            false => Ok(body),
        };
    }
    if has_scheme(uri) {
        return Err(SceneError::Outside { path: source.path.clone(), uri: uri.to_owned() });
    }
    let name = percent_decode(uri).ok_or_else(|| malformed("percent-encoded as it should be"))?;
    source.read_beside(&String::from_utf8(name).map_err(|_| malformed("UTF-8"))?)
}

/// Bytes of a percent-encoded text (RFC 3986, 2.1).
fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut bytes = text.bytes();
    let mut decoded = Vec::with_capacity(text.len());
    while let Some(byte) = bytes.next() {
        decoded.push(match byte {
            b'%' => {
                let mut digit = || (bytes.next()? as char).to_digit(16);
                (digit()? * 16 + digit()?) as u8
            }
            other => other,
        });
    }
    Some(decoded)
}

/// Bytes of a base64 text (RFC 4648, 4); padding may be missing.
fn base64_decode(text: &[u8]) -> Option<Vec<u8>> {
    let unpadded = text.iter().rposition(|&b| b != b'=').map_or(0, |last| last + 1);
    if text.len() - unpadded > 2 {
        return None;
    }
    let mut decoded = Vec::with_capacity(unpadded / 4 * 3 + 3);
    for group in text[..unpadded].chunks(4) {
        let mut bits = 0;
        for &byte in group {
            bits = bits << 6 | base64_digit(byte)?;
        }
        let whole = match group.len() {
            4 => 3,
            3 => 2,
            2 => 1,
            _ => return None,
        };
        bits <<= 6 * (4 - group.len());
        decoded.extend_from_slice(&bits.to_be_bytes()[1..=whole]);
    }
    Some(decoded)
}

fn base64_digit(byte: u8) -> Option<u32> {
    let value = match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(u32::from(value))
}
