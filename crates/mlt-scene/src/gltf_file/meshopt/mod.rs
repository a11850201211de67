//! Buffer views compressed by meshoptimizer (EXT_meshopt_compression, KHR_meshopt_compression).
//!
//! Source: the specification of EXT_meshopt_compression, appendices A (bitstream) and B (filters).

mod attributes;
mod filter;
mod indices;
#[cfg(test)]
mod tests;

use serde_json::Value;

/// The extensions' names.
pub(super) const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Largest size of an element, bytes.
const MAX_STRIDE: usize = 256;

/// How a buffer view is compressed.
#[derive(Debug, PartialEq)]
pub(super) struct Compressed {
    /// Index of the buffer that the compressed bytes are in.
    pub buffer: usize,
    /// Where they begin there.
    pub offset: usize,
    /// How many they are.
    pub length: usize,
    /// Bytes of an element.
    pub stride: usize,
    /// Number of elements.
    pub count: usize,
    mode: Mode,
    filter: Filter,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
}

impl Compressed {
    /// Reads the extension of a buffer view; `None`: it says nothing that is known.
    pub(super) fn read(extension: &Value) -> Option<Self> {
        let number = |name: &str| usize::try_from(extension.get(name)?.as_u64()?).ok();
        let (stride, count) = (number("byteStride")?, number("count")?);
        let mode = match extension.get("mode")?.as_str()? {
            "ATTRIBUTES" if stride.is_multiple_of(4) && (4..=MAX_STRIDE).contains(&stride) => Mode::Attributes,
            "TRIANGLES" if count.is_multiple_of(3) && (stride == 2 || stride == 4) => Mode::Triangles,
            "INDICES" if stride == 2 || stride == 4 => Mode::Indices,
            _ => return None,
        };
        let filter = match extension.get("filter").map_or(Some("NONE"), Value::as_str)? {
            "NONE" => Filter::None,
            "OCTAHEDRAL" if stride == 4 || stride == 8 => Filter::Octahedral,
            "QUATERNION" if stride == 8 => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            _ => return None,
        };
        let (offset, length) = (number("byteOffset").unwrap_or(0), number("byteLength")?);
        let filter = if mode == Mode::Attributes { filter } else { Filter::None };
        Some(Self { buffer: number("buffer")?, offset, length, stride, count, mode, filter })
    }

    /// Bytes of all elements; `None`: more than can be counted.
    pub(super) fn size(&self) -> Option<usize> {
        self.stride.checked_mul(self.count)
    }

    /// The elements; `None`: the bytes are not such as a compressor writes.
    pub(super) fn decode(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let mut elements = match self.mode {
            Mode::Attributes => attributes::decode(bytes, self.stride, self.count)?,
            Mode::Triangles => self.packed(&indices::triangles(bytes, self.count / 3)?),
            Mode::Indices => self.packed(&indices::sequence(bytes, self.count)?),
        };
        match self.filter {
            Filter::None => {}
            Filter::Octahedral => filter::octahedral(&mut elements, self.stride),
            Filter::Quaternion => filter::quaternion(&mut elements),
            Filter::Exponential => filter::exponential(&mut elements),
        }
        Some(elements)
    }

    /// Indices in as many bytes each as the elements have.
    fn packed(&self, indices: &[u32]) -> Vec<u8> {
        indices.iter().flat_map(|i| i.to_le_bytes().into_iter().take(self.stride)).collect()
    }
}

/// A signed integer from one whose lowest bit is its sign.
fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
