//! Typed reading of buffers; every bound is checked before a byte is read, and an element is decoded when it is asked for.

use super::{CHECK, buffer::Buffers, parse::Parsed};
use crate::{SceneError, source::Source};
use gltf::{
    Accessor, Document,
    accessor::{DataType, Dimensions},
    buffer::View,
    json::validation::Checked,
};
use std::{collections::HashMap, rc::Rc};

/// The most elements of an accessor that has no bytes for them: zeros, but for the sparse ones.
const MAX_IMPLICIT: usize = 1 << 20;

/// The most elements of any accessor: meshes number their vertices with 32 bits.
const MAX_ELEMENTS: usize = u32::MAX as usize;

/// Reads accessors.
pub(super) struct Reader<'a> {
    pub source: &'a Source<'a>,
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    vectors: HashMap<usize, Rc<Vectors<'a>>>,
}

/// The elements of an accessor of two to four components; integers become numbers as glTF says.
pub(super) struct Vectors<'a> {
    elements: Elements<'a>,
    kind: DataType,
    normalized: bool,
    components: usize,
}

/// Bytes of elements, or zeros where there are none, overlaid with the sparse ones.
struct Elements<'a> {
    dense: Option<Strided<'a>>,
    sparse: HashMap<u32, &'a [u8]>,
    count: usize,
}

/// Elements of `size` bytes, `stride` apart.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

/// Elements of `size` bytes from `offset` on in a buffer view.
struct Layout {
    offset: usize,
    size: usize,
    count: usize,
}

impl Vectors<'_> {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.elements.count
    }

    /// Components of each.
    pub(super) fn components(&self) -> usize {
        self.components
    }

    /// The element at `i`, which is less than [`count`](Self::count); components that it lacks are 0.
    pub(super) fn at<const N: usize>(&self, i: u32) -> [f32; N] {
        let size = self.kind.size();
        let decoded = |b: &[u8], k: usize| component(&b[k * size..], self.kind, self.normalized);
        let decode = |b: &[u8]| std::array::from_fn(|k| if k < self.components { decoded(b, k) } else { 0.0 });
        self.elements.at(i).map_or([0.0; N], decode)
    }
}

impl<'a> Elements<'a> {
    /// The bytes of the element at `i`; `None`: they are zeros.
    fn at(&self, i: u32) -> Option<&'a [u8]> {
        let dense = || self.dense.as_ref().map(|dense| dense.at(i as usize));
        if self.sparse.is_empty() { dense() } else { self.sparse.get(&i).copied().or_else(dense) }
    }
}

impl<'a> Strided<'a> {
    fn at(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

impl<'a> Reader<'a> {
    /// The document.
    pub(super) fn document(&self) -> &'a Document {
        self.document
    }

    /// A reader of the document's buffers.
    pub(super) fn new(source: &'a Source<'a>, parsed: &'a Parsed, buffers: &'a Buffers<'a>) -> Self {
        Self { source, document: &parsed.document, buffers, vectors: HashMap::new() }
    }

    /// The elements of an accessor of three components.
    pub(super) fn vectors(&mut self, accessor: &Accessor) -> Result<Rc<Vectors<'a>>, SceneError> {
        if accessor.dimensions() != Dimensions::Vec3 {
            self.check_type(accessor)?;
            return Err(self.invalid(accessor, "elements of three components are expected"));
        }
        self.any_vectors(accessor)
    }

    /// The elements of an accessor of any components, but for small matrices, whose columns are padded.
    pub(super) fn any_vectors(&mut self, accessor: &Accessor) -> Result<Rc<Vectors<'a>>, SceneError> {
        if let Some(known) = self.vectors.get(&accessor.index()) {
            return Ok(known.clone());
        }
        self.check_type(accessor)?;
        let components = accessor.dimensions().multiplicity();
        if matches!(accessor.dimensions(), Dimensions::Mat2 | Dimensions::Mat3) {
            return Err(self.invalid(accessor, "matrices of two or three rows are not expected"));
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let vectors = Rc::new(Vectors { elements: self.elements(accessor)?, kind, normalized, components });
        self.vectors.insert(accessor.index(), vectors.clone());
        Ok(vectors)
    }

    /// The elements of an accessor of vertex indices.
    pub(super) fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, SceneError> {
        self.check_type(accessor)?;
        if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(self.invalid(accessor, "unsigned integers are expected"));
        }
        if accessor.dimensions() != Dimensions::Scalar {
            return Err(self.invalid(accessor, "single numbers are expected"));
        }
        let elements = self.elements(accessor)?;
        Ok((0..elements.count as u32).map(|i| elements.at(i).map_or(0, index)).collect())
    }

    fn elements(&self, accessor: &Accessor) -> Result<Elements<'a>, SceneError> {
        let (size, count) = (accessor.size(), accessor.count());
        if count > MAX_ELEMENTS {
            return Err(self.source.too_large(place(accessor), "elements", MAX_ELEMENTS));
        }
        let dense = match accessor.view() {
            Some(view) => {
                let layout = Layout { offset: accessor.offset(), size, count };
                Some(self.strided(accessor, &view, layout)?)
            }
            None if count <= MAX_IMPLICIT => None,
            None => return Err(self.source.too_large(place(accessor), "elements without data", MAX_IMPLICIT)),
        };
        Ok(Elements { dense, sparse: self.sparse(accessor)?, count })
    }

    fn sparse(&self, accessor: &Accessor) -> Result<HashMap<u32, &'a [u8]>, SceneError> {
        let Some(sparse) = accessor.sparse() else { return Ok(HashMap::new()) };
        let (indices, values, count) = (sparse.indices(), sparse.values(), sparse.count());
        if count > accessor.count() {
            return Err(self.invalid(accessor, "there are more sparse elements than elements"));
        }
        let layout = Layout { offset: indices.offset(), size: indices.index_type().size(), count };
        let places = self.strided(accessor, &indices.view(), layout)?;
        let layout = Layout { offset: values.offset(), size: accessor.size(), count };
        let values = self.strided(accessor, &values.view(), layout)?;
        let pairs: HashMap<_, _> = (0..count).map(|i| (index(places.at(i)), values.at(i))).collect();
        match pairs.keys().all(|&at| (at as usize) < accessor.count()) {
            true => Ok(pairs),
            false => Err(self.invalid(accessor, "a sparse index is out of range")),
        }
    }

    /// The elements in a buffer view.
    fn strided(&self, accessor: &Accessor, view: &View, layout: Layout) -> Result<Strided<'a>, SceneError> {
        let Layout { offset, size, count } = layout;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(self.invalid(accessor, "the stride is shorter than an element"));
        }
        let bytes = self.buffers.view(view)?;
        let length = count.checked_sub(1).map_or(Some(0), |last| stride.checked_mul(last)?.checked_add(size));
        let bytes = length.and_then(|n| bytes.get(offset..offset.checked_add(n)?));
        let bytes = bytes.ok_or_else(|| self.invalid(accessor, "it ends beyond its buffer view"))?;
        Ok(Strided { bytes, stride, size })
    }

    /// Refuses types that the parser does not know, of which it allows no question.
    fn check_type(&self, accessor: &Accessor) -> Result<(), SceneError> {
        let json = &self.document.as_json().accessors[accessor.index()];
        let unknown = matches!(json.component_type, Checked::Invalid)
            || matches!(json.type_, Checked::Invalid)
            || json.sparse.as_ref().is_some_and(|sparse| matches!(sparse.indices.component_type, Checked::Invalid));
        if unknown { Err(self.invalid(accessor, "its type is not one of glTF 2.0's")) } else { Ok(()) }
    }

    fn invalid(&self, accessor: &Accessor, reason: &str) -> SceneError {
        self.source.invalid(place(accessor), reason, CHECK)
    }
}

fn place(accessor: &Accessor) -> String {
    format!("accessors[{}]", accessor.index())
}

/// A little-endian unsigned integer of as many bytes as there are, at most four.
fn index(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// One number; normalised integers stand for [-1, 1] or [0, 1].
fn component(b: &[u8], kind: DataType, normalized: bool) -> f32 {
    let (value, largest) = match kind {
        DataType::I8 => (f32::from(b[0] as i8), f32::from(i8::MAX)),
        DataType::U8 => (f32::from(b[0]), f32::from(u8::MAX)),
        DataType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])), f32::from(i16::MAX)),
        DataType::U16 => (f32::from(u16::from_le_bytes([b[0], b[1]])), f32::from(u16::MAX)),
        DataType::U32 => return u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
        DataType::F32 => return f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
