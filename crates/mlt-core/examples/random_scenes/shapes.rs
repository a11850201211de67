//! Meshes.

use libm::{cos, sin};
use mlt_core::glam::DVec3;
use mlt_core::transport::geometry::Mesh;
use std::f64::consts::{PI, TAU};

/// A rectangle about a centre, that faces `normal`.
pub(crate) fn rectangle(centre: DVec3, normal: DVec3, [a, b]: [f64; 2]) -> Mesh {
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    Mesh::quad([[-a, -b], [a, -b], [a, b], [-a, b]].map(|[x, y]| centre + x * u + y * v))
}

/// A box that faces outwards.
pub(crate) fn cuboid(centre: DVec3, half: DVec3) -> Mesh {
    let corner = |i: usize| {
        let sign = |axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
        centre + half * DVec3::new(sign(0), sign(1), sign(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}

/// A ball of few flat faces, with smooth normals or without.
pub(crate) fn ball(centre: DVec3, radius: f64, smooth: bool) -> Mesh {
    let (rows, columns) = (5u32, 8u32);
    let direction = |i: u32, j: u32| {
        let (theta, phi) = (PI * f64::from(i) / f64::from(rows), TAU * f64::from(j) / f64::from(columns));
        DVec3::new(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi))
    };
    let grid = || (0..=rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let index = |i: u32, j: u32| i * columns + j % columns;
    let faces = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let triangles = faces.flat_map(|(i, j)| {
        let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
        let upper = (i > 0).then_some([a, b, c]);
        upper.into_iter().chain((i + 1 < rows).then_some([a, c, d]))
    });
    Mesh {
        positions: grid().map(|(i, j)| centre + radius * direction(i, j)).collect(),
        normals: if smooth { grid().map(|(i, j)| direction(i, j).as_vec3()).collect() } else { Vec::new() },
        triangles: triangles.collect(),
        ..Mesh::default()
    }
}
