//! Typed reading of buffers; every bound is checked before a byte is read.

use super::CHECK;
use crate::{SceneError, geometry::MAX_ELEMENTS, source::Source};
use gltf::{
    Accessor,
    accessor::{DataType, Dimensions},
    buffer::View,
};
use std::{collections::HashMap, rc::Rc};

/// The most elements of an accessor that has no bytes for them: zeros, but for the sparse ones.
const MAX_IMPLICIT: usize = 1 << 20;

/// Reads accessors, those of vectors only once each, within the limits of a scene.
pub(super) struct Reader<'a> {
    pub source: &'a Source,
    buffers: &'a [Vec<u8>],
    vectors: HashMap<usize, Rc<[[f32; 3]]>>,
    vertices: usize,
}

/// Elements of `size` bytes from `offset` on in a buffer view.
struct Layout {
    offset: usize,
    size: usize,
    count: usize,
}

impl<'a> Reader<'a> {
    /// A reader of these buffers, which are in the document's order.
    pub fn new(source: &'a Source, buffers: &'a [Vec<u8>]) -> Self {
        Self { source, buffers, vectors: HashMap::new(), vertices: 0 }
    }

    /// The elements of an accessor of three components; integers become numbers as glTF says.
    pub fn vectors(&mut self, accessor: &Accessor) -> Result<Rc<[[f32; 3]]>, SceneError> {
        if let Some(known) = self.vectors.get(&accessor.index()) {
            return Ok(known.clone());
        }
        if accessor.dimensions() != Dimensions::Vec3 {
            return Err(self.invalid(accessor, "elements of three components are expected"));
        }
        self.vertices = self.vertices.saturating_add(accessor.count());
        if self.vertices > MAX_ELEMENTS {
            return Err(self.source.too_large(place(accessor), "vertices of the scene so far", MAX_ELEMENTS));
        }
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        let decode = |bytes: &[u8]| [0, 1, 2].map(|k| component(&bytes[k * kind.size()..], kind, normalized));
        let vectors: Rc<[_]> = self.elements(accessor, [0.0; 3], decode)?.into();
        self.vectors.insert(accessor.index(), vectors.clone());
        Ok(vectors)
    }

    /// The elements of an accessor of vertex indices.
    pub fn indices(&self, accessor: &Accessor) -> Result<Vec<u32>, SceneError> {
        if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(self.invalid(accessor, "unsigned integers are expected"));
        }
        if accessor.dimensions() != Dimensions::Scalar {
            return Err(self.invalid(accessor, "single numbers are expected"));
        }
        self.elements(accessor, 0, index)
    }

    /// Dense elements, or `zero` where there are none, overlaid with the sparse ones.
    fn elements<T: Clone>(
        &self,
        accessor: &Accessor,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, SceneError> {
        let (size, count) = (accessor.size(), accessor.count());
        let mut elements = match accessor.view() {
            Some(view) => {
                let layout = Layout { offset: accessor.offset(), size, count };
                self.strided(accessor, &view, layout)?.map(&decode).collect()
            }
            None if count <= MAX_IMPLICIT => vec![zero; count],
            None => return Err(self.source.too_large(place(accessor), "elements without data", MAX_IMPLICIT)),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values, count) = (sparse.indices(), sparse.values(), sparse.count());
            let layout = Layout { offset: indices.offset(), size: indices.index_type().size(), count };
            let places = self.strided(accessor, &indices.view(), layout)?;
            let values = self.strided(accessor, &values.view(), Layout { offset: values.offset(), size, count })?;
            for (at, value) in places.zip(values) {
                let slot = elements.get_mut(index(at) as usize);
                *slot.ok_or_else(|| self.invalid(accessor, "a sparse index is out of range"))? = decode(value);
            }
        }
        Ok(elements)
    }

    /// The bytes of each element.
    fn strided(
        &self,
        accessor: &Accessor,
        view: &View,
        layout: Layout,
    ) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, SceneError> {
        let Layout { offset, size, count } = layout;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(self.invalid(accessor, "the stride is shorter than an element"));
        }
        let view_end = view.offset().checked_add(view.length());
        let bytes = view_end.and_then(|end| self.buffers.get(view.buffer().index())?.get(view.offset()..end));
        let bytes = bytes.ok_or_else(|| self.invalid(accessor, "its buffer view ends beyond its buffer"))?;
        let length = count.checked_sub(1).map_or(Some(0), |last| stride.checked_mul(last)?.checked_add(size));
        let bytes = length.and_then(|n| bytes.get(offset..offset.checked_add(n)?));
        let bytes = bytes.ok_or_else(|| self.invalid(accessor, "it ends beyond its buffer view"))?;
        Ok(bytes.chunks(stride).map(move |chunk| &chunk[..size]))
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
