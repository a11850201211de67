//! Strata over the surface of the lights.

use super::cell::Cell;
use super::cut::{LightTree, Node};
use super::region::LightRegion;
use crate::engine::{DecodeError, Reader, put_list};
use crate::transport::scene::{Light, LightPoint, Lights};
use glam::DVec2;
use std::cmp::Ordering;
use std::fmt;

/// How the lights are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stratification {
    /// Not at all: one stratum.
    #[default]
    None,
    /// N×M cells of a rectangle and of an environment; N·M parts of equal power of any other light that has a size; one of a light without.
    Grid(u32, u32),
    /// The cut through the tree of lights into so many nodes that halves the most powerful one first.
    Count(u32),
    /// The cut that the pilot of a render finds; without a pilot, one stratum.
    Auto,
}

impl Stratification {
    /// Least number of strata that it asks for.
    pub fn least(self) -> usize {
        match self {
            Self::None | Self::Auto => 1,
            Self::Count(count) => count as usize,
            Self::Grid(columns, rows) => columns as usize * rows as usize,
        }
    }
}

impl fmt::Display for Stratification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Auto => f.write_str("auto"),
            Self::Count(count) => write!(f, "{count}"),
            Self::Grid(columns, rows) => write!(f, "{columns}x{rows}"),
        }
    }
}

/// Most strata, whatever is asked for.
const MOST_STRATA: f64 = 65_536.0;

/// Most cells of all grids in a partition that is read.
const MOST_CELLS: u64 = 1 << 24;

/// A partition of the lights. docs/theory-strata.md, section 1, has how it cuts path space.
#[derive(Clone, Debug)]
pub struct LightStrata {
    regions: Vec<LightRegion>,
    /// All parts as one.
    whole: LightRegion,
    grids: Vec<Grid>,
    /// The part of each cell of the grids.
    table: Vec<u32>,
}

/// Cells of one light.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// Index of its first cell in the table.
    first: u32,
    /// Cells along u and v.
    size: [u32; 2],
}

impl LightStrata {
    /// Cuts the lights.
    pub fn new(lights: &Lights, stratification: Stratification) -> Self {
        Self::with_least_share(lights, stratification, 0.0)
    }

    /// Cuts the lights into parts that have no less than the share `least` of the power: what would be smaller is joined
    /// with its neighbours.
    pub fn with_least_share(lights: &Lights, stratification: Stratification, least: f64) -> Self {
        let power = lights.power();
        // Lights without any power cannot be told apart.
        if power.partial_cmp(&0.0).is_none_or(Ordering::is_le) {
            return Self::assemble(lights, vec![(0..lights.lights.len() as u32).map(Cell::whole).collect()]);
        }
        let least = least.max(1.0 / MOST_STRATA) * power;
        let tree = LightTree::new(lights);
        let count = match stratification {
            Stratification::Grid(n, m) => return Self::grid(lights, &tree, [n.max(1), m.max(1)], least),
            Stratification::Count(count) => count as usize,
            Stratification::None | Stratification::Auto => 1,
        };
        Self::of_cut(lights, &tree, &tree.cut(count, least), least)
    }

    fn grid(lights: &Lights, tree: &LightTree, size: [u32; 2], least: f64) -> Self {
        let cells = |position| {
            let (id, light) = tree.light(position);
            grid_cells(id, joined_grid(light, size, least))
        };
        let cells = (0..tree.len()).flat_map(cells);
        let mut parts = join(cells.map(|cell| (cell.power(&lights.lights), vec![cell])), least);
        parts.sort_by_cached_key(|cells| cells.iter().map(place).min());
        Self::assemble(lights, parts)
    }

    /// The strata of a cut whose nodes are in the tree's order; nodes of less power than `least` are joined. With `least`
    /// 0, stratum j is node j.
    pub fn of_cut(lights: &Lights, tree: &LightTree, nodes: &[Node], least: f64) -> Self {
        Self::assemble(lights, join(nodes.iter().map(|&node| (tree.power(node), tree.cells(node))), least))
    }

    /// The parts, in the order of [`index`](Self::index).
    pub fn regions(&self) -> &[LightRegion] {
        &self.regions
    }

    /// All parts as one.
    pub fn whole(&self) -> &LightRegion {
        &self.whole
    }

    /// The part that a point lies in, in constant time.
    #[inline]
    pub fn index(&self, point: &LightPoint) -> u32 {
        let Grid { first, size: [nu, nv] } = self.grids[point.light as usize];
        self.table[(first + cell(point.v, nv) * nu + cell(point.u, nu)) as usize]
    }

    /// Appends it to bytes.
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        put_list(to, &self.regions, |to, region| put_list(to, region.cells(), |to, cell| cell.write(to)));
    }

    /// Reads a partition of these lights that [`write`](Self::write) has written.
    pub(crate) fn read(lights: &Lights, from: &mut Reader) -> Result<Self, DecodeError> {
        let parts = from.list(|from| from.list(Cell::read))?;
        if is_partition(lights.lights.len(), &parts) {
            Ok(Self::assemble(lights, parts))
        } else {
            Err(DecodeError::Damaged)
        }
    }

    /// Strata of disjoint cells that cover the lights and lie, on each light, on one grid.
    fn assemble(lights: &Lights, mut parts: Vec<Vec<Cell>>) -> Self {
        parts.iter_mut().for_each(|cells| cells.sort_unstable_by_key(place));
        let sizes = grid_sizes(lights.lights.len(), &parts);
        let mut entries = 0;
        let mut grid = |size: [u32; 2]| {
            let grid = Grid { first: entries, size };
            entries += size[0] * size[1];
            grid
        };
        let grids: Vec<_> = sizes.into_iter().map(&mut grid).collect();
        let mut table = vec![0; entries as usize];
        for (j, cell) in (0..).zip(&parts).flat_map(|(j, cells)| cells.iter().map(move |cell| (j, cell))) {
            grids[cell.light as usize].fill(&mut table, cell, j);
        }
        let regions: Vec<_> = parts.into_iter().map(|cells| LightRegion::new(lights, cells)).collect();
        let whole = match &regions[..] {
            [whole] => whole.clone(),
            _ => LightRegion::whole(lights),
        };
        Self { regions, whole, grids, table }
    }
}

/// The grid that each light's cells lie on: that of the narrowest ones.
fn grid_sizes(lights: usize, parts: &[Vec<Cell>]) -> Vec<[u32; 2]> {
    let mut sizes = vec![[1, 1]; lights];
    for cell in parts.iter().flatten() {
        let (size, cells) = (&mut sizes[cell.light as usize], (cell.high - cell.low).recip().round());
        *size = [size[0].max(cells.x as u32), size[1].max(cells.y as u32)];
    }
    sizes
}

/// Whether parts from wherever they come hold each cell of the lights' grids once.
fn is_partition(lights: usize, parts: &[Vec<Cell>]) -> bool {
    if parts.iter().any(Vec::is_empty) || parts.iter().flatten().any(|cell| cell.light as usize >= lights) {
        return false;
    }
    let sizes = grid_sizes(lights, parts);
    let cells_of = |&[nu, nv]: &[u32; 2]| u64::from(nu).saturating_mul(u64::from(nv));
    if sizes.iter().map(cells_of).fold(0, u64::saturating_add) > MOST_CELLS {
        return false;
    }
    let mut met: Vec<_> = sizes.iter().map(|size| vec![false; cells_of(size) as usize]).collect();
    let alone =
        parts.iter().flatten().all(|cell| meet(&mut met[cell.light as usize], sizes[cell.light as usize], cell));
    alone && met.iter().flatten().all(|&met| met)
}

/// Marks a cell's part of a grid; `false` if it does not lie on the grid's lines, or if any of it was marked before.
fn meet(met: &mut [bool], size: [u32; 2], cell: &Cell) -> bool {
    let n = size.map(f64::from);
    let [low, high] = [cell.low, cell.high].map(|corner| [0, 1].map(|axis| (corner[axis] * n[axis]).round()));
    let on_lines = |axis: usize| low[axis] / n[axis] == cell.low[axis] && high[axis] / n[axis] == cell.high[axis];
    let mut rows = low[1] as usize..high[1] as usize;
    on_lines(0)
        && on_lines(1)
        && rows.all(|row| {
            let row = &mut met[row * size[0] as usize..][low[0] as usize..high[0] as usize];
            !row.iter_mut().any(|met| std::mem::replace(met, true))
        })
}

impl Grid {
    /// Enters part j for a cell that is a rectangle of the grid's cells.
    fn fill(&self, table: &mut [u32], cell: &Cell, j: u32) {
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let [low, high] = [cell.low, cell.high].map(|p| (p * size).round().as_uvec2());
        for row in low.y..high.y {
            let start = self.first + row * self.size[0];
            table[(start + low.x) as usize..(start + high.x) as usize].fill(j);
        }
    }
}

/// Sorts cells by their lights, then row by row.
fn place(cell: &Cell) -> (u32, u64, u64) {
    (cell.light, cell.low.y.to_bits(), cell.low.x.to_bits())
}

/// Joins runs of neighbours, given with their powers, until each has the power `least`.
fn join(nodes: impl Iterator<Item = (f64, Vec<Cell>)>, least: f64) -> Vec<Vec<Cell>> {
    let (mut parts, mut open, mut sum) = (Vec::<Vec<Cell>>::new(), Vec::new(), 0.0);
    for (power, cells) in nodes {
        open.extend(cells);
        sum += power;
        // A hair less is not less: the shares of equal cells are sums with rounding errors.
        if sum >= 0.999 * least {
            parts.push(std::mem::take(&mut open));
            sum = 0.0;
        }
    }
    match parts.last_mut() {
        Some(last) => last.extend(open),
        None => parts.push(open),
    }
    parts
}

/// The grid of a light, coarser where its cells would have less power than `least`.
fn joined_grid(light: &Light, mut size: [u32; 2], least: f64) -> [u32; 2] {
    while size != [1, 1] && light.power() / f64::from(size[0]) / f64::from(size[1]) < 0.999 * least {
        let longer = usize::from(size[1] > size[0]);
        size[longer] = size[longer].div_ceil(2);
    }
    light.grid(size)
}

/// Index of the interval [i/n, (i+1)/n) that x lies in, bounds rounded as the regions' are.
#[inline]
fn cell(x: f64, n: u32) -> u32 {
    if n == 1 {
        return 0;
    }
    let bound = |i: u32| f64::from(i) / f64::from(n);
    let i = ((x * f64::from(n)) as u32).min(n - 1);
    if x < bound(i) {
        i - 1
    } else if i + 1 < n && x >= bound(i + 1) {
        i + 1
    } else {
        i
    }
}

fn grid_cells(light: u32, [nu, nv]: [u32; 2]) -> impl Iterator<Item = Cell> {
    let size = DVec2::new(f64::from(nu), f64::from(nv));
    (0..nv).flat_map(move |j| (0..nu).map(move |i| DVec2::new(f64::from(i), f64::from(j)))).map(move |corner| Cell {
        light,
        low: corner / size,
        high: (corner + DVec2::ONE) / size,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Purpose, generator, sealed, uniform, unsealed};
    use crate::transport::colour::Rgb;
    use crate::transport::geometry::Mesh;
    use crate::transport::scene::Material;
    use crate::transport::scene::light::Shape;
    use glam::{DVec3, Vec3};

    /// A light of a mesh for each emission: a quad of side 1 by 2, or scattered triangles where `triangles` is not 0.
    fn lights(emissions: &[f32], triangles: u32) -> Lights {
        let mut rng = generator(3, Purpose::Sample, 0, 0, 0);
        let mut mesh = |i: usize| {
            let at = DVec3::new(3.0 * i as f64, 0.0, 0.0);
            let quad = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), 2.0 * DVec3::Y].map(|p| at + p);
            let (mut positions, mut indices) = (quad.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
            if triangles > 0 {
                let mut point = || DVec3::from_array([(); 3].map(|()| uniform(&mut rng)));
                positions = (0..triangles).flat_map(|_| [point() * 10.0; 3]).collect();
                positions.iter_mut().for_each(|p| *p += 0.01 * point());
                indices = (0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            }
            Mesh { positions, triangles: indices, material: i as u32, ..Mesh::default() }
        };
        let meshes: Vec<_> = (0..emissions.len()).map(&mut mesh).collect();
        let material = |&e: &f32| Material { emission: Rgb::splat(e), ..Material::default() };
        let materials: Vec<_> = emissions.iter().map(material).collect();
        let corner = |m: &Mesh, t: &[u32; 3]| t.map(|i| m.positions[i as usize].as_vec3());
        let primitives: Vec<[Vec3; 3]> =
            meshes.iter().flat_map(|m| m.triangles.iter().map(|t| corner(m, t)).collect::<Vec<_>>()).collect();
        Lights::new(&meshes, &materials, &[], &primitives)
    }

    /// The partition that is read back from a partition's bytes, after a change of its parts.
    fn read_back(lights: &Lights, strata: &LightStrata, change: impl Fn(&mut Vec<Vec<Cell>>)) -> Option<LightStrata> {
        let mut parts: Vec<_> = strata.regions().iter().map(|region| region.cells().to_vec()).collect();
        change(&mut parts);
        let write = |to: &mut Vec<u8>| put_list(to, &parts, |to, part| put_list(to, part, |to, cell| cell.write(to)));
        let bytes = sealed(*b"a strata", 1, write);
        unsealed(&bytes, *b"a strata", 1, |from| LightStrata::read(lights, from)).ok()
    }

    #[test]
    fn what_is_read_back_is_a_partition() {
        for lights in [lights(&[1.0], 0), lights(&[1.0, 40.0, 3.0, 0.01, 7.0], 0), lights(&[2.0, 1.0, 5.0], 50)] {
            for cut in [Stratification::None, Stratification::Count(7), Stratification::Grid(3, 5)] {
                let strata = LightStrata::new(&lights, cut);
                let same = read_back(&lights, &strata, |_| ()).expect("a partition");
                let cells =
                    |strata: &LightStrata| strata.regions().iter().flat_map(|r| r.cells().to_vec()).collect::<Vec<_>>();
                assert!(cells(&same) == cells(&strata) && same.table == strata.table);
                let changes: [fn(&mut Vec<Vec<Cell>>); 5] = [
                    |parts| drop(parts.pop()),
                    |parts| parts.push(parts[0].clone()),
                    |parts| parts.push(Vec::new()),
                    |parts| parts[0][0].light = 99,
                    |parts| parts[0][0].high.y *= 0.9,
                ];
                assert!(changes.into_iter().all(|change| read_back(&lights, &strata, change).is_none()), "{cut:?}");
            }
        }
    }

    /// Every point lies in the region that its index names and in no other, and powers add up.
    fn check_partition(lights: &Lights, strata: &LightStrata) {
        let total: f64 = strata.regions().iter().map(LightRegion::power).sum();
        assert!((total / lights.power() - 1.0).abs() < 1e-9);
        let mut rng = generator(1, Purpose::Sample, 0, 0, 0);
        let inside = |c: &Cell, p: &LightPoint| {
            c.light == p.light && (c.low.x..c.high.x).contains(&p.u) && (c.low.y..c.high.y).contains(&p.v)
        };
        for _ in 0..300 {
            let light = (uniform(&mut rng) * lights.lights.len() as f64) as u32;
            let point = LightPoint { light, u: uniform(&mut rng), v: uniform(&mut rng) };
            let holds = |r: &LightRegion| r.cells().iter().any(|c| inside(c, &point));
            let holders: Vec<_> = (0..).zip(strata.regions()).filter(|(_, r)| holds(r)).map(|(j, _)| j).collect();
            assert_eq!(holders, [strata.index(&point)]);
        }
        for (j, region) in (0..).zip(strata.regions()).take(200) {
            let point = region.sample(uniform(&mut rng), uniform(&mut rng));
            assert_eq!(strata.index(&point), j);
        }
    }

    #[test]
    fn every_cut_is_a_partition() {
        for lights in [lights(&[1.0], 0), lights(&[1.0, 40.0, 3.0, 0.01, 7.0], 0), lights(&[2.0, 1.0, 5.0], 50)] {
            let cuts = [1, 2, 3, 7, 16, 100].map(Stratification::Count);
            let grids = [(1, 1), (4, 4), (3, 5), (1, 64)].map(|(n, m)| Stratification::Grid(n, m));
            for stratification in cuts.into_iter().chain(grids).chain([Stratification::None]) {
                for least in [0.0, 0.01, 0.2] {
                    check_partition(&lights, &LightStrata::with_least_share(&lights, stratification, least));
                }
            }
        }
    }

    #[test]
    fn a_count_is_kept_and_the_powerful_are_cut_first() {
        let lights = lights(&[1.0, 16.0, 1.0], 0);
        for count in 1..40 {
            assert_eq!(LightStrata::new(&lights, Stratification::Count(count)).regions().len(), count as usize);
        }
        let strata = LightStrata::new(&lights, Stratification::Count(10));
        let of_light = |i| strata.regions().iter().filter(|r| r.cells()[0].light == i).count();
        assert_eq!([0, 1, 2].map(of_light), [1, 8, 1]);
    }

    #[test]
    fn a_rectangle_halves_along_its_longer_side() {
        let strata = LightStrata::new(&lights(&[1.0], 0), Stratification::Count(2));
        let sizes: Vec<_> = strata.regions().iter().map(|r| r.cells()[0].high - r.cells()[0].low).collect();
        let halved = if strata.grids[0].size == [1, 2] { DVec2::new(1.0, 0.5) } else { DVec2::new(0.5, 1.0) };
        assert_eq!(sizes, [halved; 2]);
        let strata = LightStrata::new(&lights(&[1.0], 0), Stratification::Count(8));
        let mut size = strata.grids[0].size;
        size.sort_unstable();
        assert_eq!(size, [2, 4], "the cells of 1 by 2 are squares of a half");
    }

    #[test]
    fn a_grid_keeps_its_order_and_is_joined_where_its_cells_are_too_weak() {
        let lights = lights(&[4.0, 1.0], 0);
        let strata = |least| LightStrata::with_least_share(&lights, Stratification::Grid(3, 2), least);
        let place = |r: &LightRegion| (r.cells()[0].light, r.cells()[0].low.y, r.cells()[0].low.x);
        let places: Vec<_> = strata(0.0).regions().iter().map(place).collect();
        assert!(places.len() == 12 && places.is_sorted());
        let least = |least| {
            let shares: Vec<_> = strata(least).regions().iter().map(|r| r.power() / lights.power()).collect();
            assert!(shares.iter().all(|&s| s > 0.998 * least), "{shares:?}");
            shares.len()
        };
        assert_eq!([0.03, 0.1, 0.13, 0.2, 0.3, 0.9].map(least), [12, 8, 7, 5, 2, 1]);
    }

    /// Structure, not seconds: strata, cells and table stay in proportion to the lights.
    #[test]
    fn four_hundred_thousand_triangles_make_few_strata() {
        let one_mesh = lights(&[1.0], 400_000);
        let many = lights(&vec![1.0; 20_000], 1);
        for (lights, count) in [(&one_mesh, 1), (&many, 20_000)] {
            assert_eq!(lights.lights.len(), count);
            for stratification in [Stratification::Grid(64, 64), Stratification::Count(100_000)] {
                let strata = LightStrata::with_least_share(lights, stratification, 1.0 / 1024.0);
                assert!((400..=1024).contains(&strata.regions().len()), "{}", strata.regions().len());
                assert!(strata.table.len() <= 4096 + count);
                assert!(strata.regions().iter().map(|r| r.cells().len()).sum::<usize>() <= 4096 + count);
                check_partition(lights, &strata);
            }
        }
    }

    #[test]
    fn a_cell_of_a_mesh_is_a_compact_patch() {
        let lights = lights(&[1.0], 20_000);
        let Shape::Area(mesh) = &lights.lights[0].shape else { panic!("a mesh") };
        let strata = LightStrata::new(&lights, Stratification::Count(64));
        let mut rng = generator(2, Purpose::Sample, 0, 0, 0);
        let mut spread = |region: &LightRegion| {
            let points: Vec<_> = (0..50).map(|_| region.sample(uniform(&mut rng), uniform(&mut rng))).collect();
            let places: Vec<_> = points.iter().map(|p| mesh.at(p.u, p.v).1).collect();
            let mean = places.iter().sum::<Vec3>() / 50.0;
            places.iter().map(|p| p.distance_squared(mean)).sum::<f32>() / 50.0
        };
        let whole = spread(&LightRegion::whole(&lights));
        let parts = strata.regions().iter().map(&mut spread).sum::<f32>() / 64.0;
        assert!(parts < 0.12 * whole, "{parts} of {whole}");
    }
}
