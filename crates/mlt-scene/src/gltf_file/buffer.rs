//! Where a glTF file's bytes come from: the GLB chunk, data URIs, files beside it.

use super::{
    CHECK,
    meshopt::{self, Compressed},
    parse::Parsed,
};
use crate::{
    SceneError,
    source::{Source, has_scheme},
};
use base64::{
    Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use gltf::{
    Buffer, Document,
    buffer::{self, View},
};
use std::{cell::OnceCell, io::ErrorKind};

/// Base64 (RFC 4648, 4) whose padding may be missing.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The buffers of a document, each read when it is first asked for.
pub(super) struct Buffers<'a> {
    source: &'a Source<'a>,
    binary: Option<&'a [u8]>,
    read: Vec<OnceCell<Vec<u8>>>,
    document: &'a Document,
    /// Of each buffer view that is compressed, its content.
    decoded: Vec<OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    /// Reads nothing yet.
    pub(super) fn new(source: &'a Source<'a>, parsed: &'a Parsed) -> Self {
        let document = &parsed.document;
        let read = document.buffers().map(|_| OnceCell::new()).collect();
        let decoded = document.views().map(|_| OnceCell::new()).collect();
        Self { source, binary: parsed.binary(), read, document, decoded }
    }

    /// The content of a buffer, at least as long as the document says.
    pub(super) fn content(&self, buffer: &Buffer) -> Result<&[u8], SceneError> {
        let place = format!("buffers[{}]", buffer.index());
        let bytes = match (buffer.source(), self.binary) {
            (buffer::Source::Bin, Some(binary)) if buffer.index() == 0 => binary,
            (buffer::Source::Bin, _) => return Err(self.missing(buffer, &place)),
            (buffer::Source::Uri(uri), _) => {
                let cell = &self.read[buffer.index()];
                if cell.get().is_none() {
                    _ = cell.set(read_uri(self.source, &place, uri)?);
                }
                cell.get().map_or(&[][..], Vec::as_slice)
            }
        };
        if bytes.len() < buffer.length() {
            let reason = format!("{} bytes are announced and {} are there", buffer.length(), bytes.len());
            return Err(self.source.invalid(place, reason, "fetch the file again, it seems cut off"));
        }
        Ok(bytes)
    }

    /// The content of a buffer view, given by its index.
    pub(super) fn view_at(&self, index: usize) -> Result<&[u8], SceneError> {
        let view = self.document.views().nth(index).ok_or_else(|| self.invalid(index, "it does not exist"))?;
        self.view(&view)
    }

    /// The content of a buffer view, decompressed if need be.
    pub(super) fn view(&self, view: &View) -> Result<&[u8], SceneError> {
        let extension = meshopt::NAMES.iter().find_map(|name| Some((*name, view.extension_value(name)?)));
        let Some((name, value)) = extension else {
            return self.part(view.index(), &view.buffer(), [view.offset(), view.length()]);
        };
        let cell = &self.decoded[view.index()];
        if cell.get().is_none() {
            let compressed = Compressed::read(value).ok_or_else(|| self.source.compressed(name))?;
            _ = cell.set(self.decode(view.index(), &compressed)?);
        }
        Ok(cell.get().map_or(&[][..], Vec::as_slice))
    }

    fn decode(&self, index: usize, compressed: &Compressed) -> Result<Vec<u8>, SceneError> {
        let buffer = self.document.buffers().nth(compressed.buffer);
        let buffer = buffer.ok_or_else(|| self.invalid(index, "its compressed content is in no buffer"))?;
        let bytes = self.part(index, &buffer, [compressed.offset, compressed.length])?;
        let size = compressed.size().ok_or_else(|| self.invalid(index, "its elements are too many"))?;
        self.source.take(size as u64, format!("bufferViews[{index}] of {size} bytes"))?;
        compressed.decode(bytes).ok_or_else(|| self.invalid(index, "its compressed content is damaged"))
    }

    /// Bytes of a buffer, from an offset on, for a view.
    fn part(&self, index: usize, buffer: &Buffer, [offset, length]: [usize; 2]) -> Result<&[u8], SceneError> {
        let bytes = self.content(buffer)?;
        let bytes = offset.checked_add(length).and_then(|end| bytes.get(offset..end));
        bytes.ok_or_else(|| self.invalid(index, "it ends beyond its buffer"))
    }

    fn invalid(&self, view: usize, reason: &str) -> SceneError {
        self.source.invalid(format!("bufferViews[{view}]"), reason, CHECK)
    }

    /// The content that a URI names or holds; `place` names its owner.
    pub(super) fn read_uri(&self, place: &str, uri: &str) -> Result<Vec<u8>, SceneError> {
        read_uri(self.source, place, uri)
    }

    /// The error for a buffer that has no content: another stands for it, compressed, or it is forgotten.
    fn missing(&self, buffer: &Buffer, place: &str) -> SceneError {
        let fallback = meshopt::NAMES.iter().find(|name| buffer.extension_value(name).is_some());
        match fallback {
            Some(extension) => self.source.compressed(extension),
            None => self.source.invalid(place, "there is neither a URI nor a binary chunk", CHECK),
        }
    }
}

fn read_uri(source: &Source, place: &str, uri: &str) -> Result<Vec<u8>, SceneError> {
    match uri.split_at_checked("data:".len()) {
        Some((scheme, data)) if scheme.eq_ignore_ascii_case("data:") => read_data(source, place, data),
        _ if has_scheme(uri) => Err(source.outside(uri)),
        _ => read_file(source, uri),
    }
}

/// The content of a data URI (RFC 2397), in which blanks and line breaks count for nothing.
fn read_data(source: &Source, place: &str, data: &str) -> Result<Vec<u8>, SceneError> {
    let malformed = |what: &str| source.invalid(place, format!("the URI is not {what}"), CHECK);
    source.take(data.len() as u64, place)?;
    let (head, body) = data.split_once(',').ok_or_else(|| malformed("a complete data URI"))?;
    let mut body = percent_decode(body).ok_or_else(|| malformed("percent-encoded as it should be"))?;
    if head.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64")) {
        body.retain(|byte| !byte.is_ascii_whitespace());
        body = BASE64.decode(body).map_err(|_| malformed("base64 as it says"))?;
    }
    Ok(body)
}

/// The file whose name is the URI decoded, or the URI as it stands: some programs do not encode what they write.
fn read_file(source: &Source, uri: &str) -> Result<Vec<u8>, SceneError> {
    let name = percent_decode(uri).and_then(|name| String::from_utf8(name).ok());
    match name.map(|name| source.read_beside(&name)) {
        None => source.read_beside(uri),
        Some(Err(SceneError::Read { cause, path })) if cause.kind() == ErrorKind::NotFound && uri.contains('%') => {
            source.read_beside(uri).map_err(|_| SceneError::Read { cause, path })
        }
        Some(read) => read,
    }
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
