//! The codecs of vertex indices: triangles that share edges and vertices with the last ones, and sequences.

use super::unzigzag;

/// Bytes read one by one.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    /// An integer of seven bits a byte, the lowest first.
    fn integer(&mut self) -> Option<u32> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.next()?;
            value |= u32::from(byte & 127).wrapping_shl(shift);
            if byte < 128 {
                return Some(value);
            }
        }
        None
    }

    /// An index by its difference from one before.
    fn index(&mut self, last: u32) -> Option<u32> {
        Some(last.wrapping_add(unzigzag(self.integer()?)))
    }
}

/// The last sixteen of something.
struct Recent<T>([T; 16], usize);

impl<T: Copy> Recent<T> {
    fn push(&mut self, item: T) {
        self.0[self.1 % 16] = item;
        self.1 += 1;
    }

    /// The one that was pushed `ago` others before the last.
    fn get(&self, ago: usize) -> T {
        self.0[(self.1 + 15 - ago) % 16]
    }
}

struct Triangles<'a> {
    data: Bytes<'a>,
    /// Codes of triangles that share nothing.
    table: &'a [u8],
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// The first vertex that no triangle had.
    next: u32,
    /// The last vertex that was written out.
    last: u32,
    /// Codes of a third vertex from this on have a meaning of their own.
    most_recent: u8,
}

/// The corners of `count` triangles.
pub(super) fn triangles(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, rest) = bytes.split_first()?;
    let most_recent = match header {
        0xe0 => 15,
        0xe1 => 13,
        _ => return None,
    };
    let (rest, table) = rest.split_at_checked(rest.len().checked_sub(16)?)?;
    let (codes, data) = rest.split_at_checked(count)?;
    let mut triangles = Triangles {
        data: Bytes(data),
        table,
        edges: Recent([[0; 2]; 16], 0),
        vertices: Recent([0; 16], 0),
        next: 0,
        last: 0,
        most_recent,
    };
    let mut corners = Vec::with_capacity(3 * count);
    for &code in codes {
        corners.extend(if code < 0xf0 { triangles.at_edge(code)? } else { triangles.apart(code)? });
    }
    triangles.data.0.is_empty().then_some(corners)
}

impl Triangles<'_> {
    /// A triangle that shares an edge.
    fn at_edge(&mut self, code: u8) -> Option<[u32; 3]> {
        let [a, b] = self.edges.get(usize::from(code >> 4));
        let third = code & 15;
        let c = match third {
            0 => self.new_vertex(),
            1.. if third < self.most_recent => self.vertices.get(usize::from(third)),
            13 => self.written(self.last.wrapping_sub(1)),
            14 => self.written(self.last.wrapping_add(1)),
            _ => {
                let c = self.data.index(self.last)?;
                self.written(c)
            }
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Some([a, b, c])
    }

    fn new_vertex(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        self.vertices.push(vertex);
        vertex
    }

    fn written(&mut self, vertex: u32) -> u32 {
        self.last = vertex;
        self.vertices.push(vertex);
        vertex
    }

    /// A triangle that shares vertices at most.
    fn apart(&mut self, code: u8) -> Option<[u32; 3]> {
        let both = if code < 0xfe { self.table[usize::from(code & 15)] } else { self.data.next()? };
        if code >= 0xfe && both == 0 {
            self.next = 0;
        }
        let kinds = [if code == 0xff { 15 } else { 0 }, both >> 4, both & 15];
        // Those before this triangle count, whichever of its own vertices are new.
        let shared = kinds.map(|kind| self.vertices.get(usize::from(kind.max(1)) - 1));
        // All new ones have their numbers before any that is written out.
        let mut corners = shared;
        for (corner, _) in corners.iter_mut().zip(kinds).filter(|(_, kind)| *kind == 0) {
            *corner = self.next;
            self.next = self.next.wrapping_add(1);
        }
        for (corner, kind) in corners.iter_mut().zip(kinds) {
            if kind == 15 && code >= 0xfe {
                self.last = self.data.index(self.last)?;
                *corner = self.last;
            }
            if kind == 0 || (kind == 15 && code >= 0xfe) {
                self.vertices.push(*corner);
            }
        }
        let [a, b, c] = corners;
        [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| self.edges.push(edge));
        Some(corners)
    }
}

/// `count` indices, each from the last one of two.
pub(super) fn sequence(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (&header, rest) = bytes.split_first()?;
    let (rest, _) = rest.split_at_checked(rest.len().checked_sub(4)?)?;
    if !matches!(header, 0xd0 | 0xd1) || rest.len() < count {
        return None;
    }
    let (mut data, mut last) = (Bytes(rest), [0u32; 2]);
    let next = |_| {
        let v = data.integer()?;
        let last = &mut last[(v & 1) as usize];
        *last = last.wrapping_add(unzigzag(v >> 1));
        Some(*last)
    };
    let indices = (0..count).map(next).collect::<Option<_>>()?;
    data.0.is_empty().then_some(indices)
}
