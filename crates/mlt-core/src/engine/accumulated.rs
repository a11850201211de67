//! Sums of rounds: all that has to outlive a process.

use super::bytes::{put_list, put_text};
use super::{Counted, DecodeError, Film, MergeError, Reader, Rounds};

/// Names and values of what decides the bits of a round: scene, method, seed and so on. Only what has the same key adds up.
pub type Key = Vec<(String, String)>;

/// Sums of rounds, with what was counted in them: a render as far as it went, or a part of one.
///
/// Any grouping and order of the same rounds, over threads, processes or machines, gives the same sums, and the same bytes.
#[derive(Clone, Debug)]
pub struct Accumulated<const C: usize, T> {
    key: Key,
    pub(super) film: Film<C>,
    pub(super) tally: T,
}

impl<const C: usize, T: Counted> Accumulated<C, T> {
    /// No rounds, on a film that holds none.
    pub fn new(film: Film<C>) -> Self {
        Self { key: Key::new(), film, tally: T::default() }
    }

    /// The same of a render with this key.
    #[must_use]
    pub fn with_key(self, key: Key) -> Self {
        Self { key, ..self }
    }

    /// The image.
    pub fn film(&self) -> &Film<C> {
        &self.film
    }

    /// Counts of the rounds.
    pub fn tally(&self) -> &T {
        &self.tally
    }

    /// The rounds that it holds.
    pub fn rounds(&self) -> &Rounds {
        self.film.rounds_held()
    }

    /// Names and values that decide the bits of its rounds.
    pub fn key(&self) -> &Key {
        &self.key
    }

    /// Takes what its rounds have made, apart.
    pub fn into_parts(self) -> (Film<C>, T) {
        (self.film, self.tally)
    }

    /// Frees the memory of the round that is being made; no more are.
    pub fn finish(&mut self) {
        self.film.finish();
    }

    /// Forgets all rounds.
    pub fn clear(&mut self) {
        self.film.clear();
        self.tally = T::default();
    }

    /// Adds another part of the same render.
    ///
    /// # Errors
    ///
    /// Changes nothing if the keys differ, if the films do, or if both parts hold a round.
    pub fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        if let Some(difference) = key_difference(&self.key, &other.key) {
            return Err(difference);
        }
        self.film.merge(&other.film)?;
        self.tally.merge(&other.tally);
        Ok(())
    }

    /// Appends all of it but the round that is being made to bytes: the same for the same rounds.
    pub fn write(&self, to: &mut Vec<u8>) {
        to.extend((C as u32).to_le_bytes());
        put_key(to, &self.key);
        self.film.write(to);
        self.tally.write(to);
    }

    /// Reads what [`write`](Self::write) has written, from wherever it comes: no bytes make it panic, or take much more memory
    /// than they have themselves.
    ///
    /// # Errors
    ///
    /// If the bytes were not written by it.
    pub fn read(from: &mut Reader) -> Result<Self, DecodeError> {
        let channels = from.bytes().map(u32::from_le_bytes)?;
        if channels != C as u32 {
            return Err(DecodeError::Channels(channels));
        }
        Ok(Self { key: read_key(from)?, film: Film::read(from)?, tally: T::read(from)? })
    }
}

/// The first entry that differs, if two keys are not of one render.
pub fn key_difference(a: &Key, b: &Key) -> Option<MergeError> {
    let value = |key: &Key, name: &str| {
        key.iter().find(|(other, _)| other == name).map_or_else(|| "missing".into(), |(_, value)| value.clone())
    };
    let differing = a.iter().chain(b).map(|(name, _)| (name, [value(a, name), value(b, name)]));
    let first = differing.into_iter().find(|(_, [a, b])| a != b);
    first.map(|(name, values)| MergeError::Key { name: name.clone(), values })
}

/// Appends a key to bytes.
pub fn put_key(to: &mut Vec<u8>, key: &Key) {
    put_list(to, key, |to, (name, value)| [name, value].into_iter().for_each(|text| put_text(to, text)));
}

/// Reads what [`put_key`] has written.
///
/// # Errors
///
/// If the bytes were not written by it.
pub fn read_key(from: &mut Reader) -> Result<Key, DecodeError> {
    from.list(|from| Ok((from.text()?, from.text()?)))
}

#[cfg(all(test, feature = "checkpoints"))]
mod tests {
    use super::*;
    use crate::engine::sealed::checksum;
    use crate::engine::{Metropolis, Mixture, Mutation, Path, Share, Splat, Stratum, Tally, render, uniform};
    use rand_pcg::rand_core::Rng;
    use std::ops::{ControlFlow, Range};

    #[derive(Clone)]
    struct X(f64);

    impl Path for X {
        type Splat = Splat<2>;

        fn splats(&self) -> impl Iterator<Item = Splat<2>> {
            std::iter::once(Splat { site: (3.0 * self.0) as u32, value: [self.0, self.0.sqrt()] })
        }
    }

    struct Cell {
        low: f64,
    }

    impl Stratum<X> for Cell {
        fn contains(&self, x: &X) -> bool {
            (self.low..self.low + 0.5).contains(&x.0)
        }

        fn sample(&self, rng: &mut impl Rng, visit: &mut impl FnMut(&X, f64)) {
            visit(&X(self.low + 0.5 * uniform(rng)), 0.5);
        }

        fn density(&self, _: &X) -> f64 {
            2.0
        }

        fn power(&self) -> f64 {
            1.0
        }
    }

    struct Nudge;

    impl Mutation<X, Cell> for Nudge {
        fn name(&self) -> &'static str {
            "nudge"
        }

        fn propose(&self, x: &X, y: &mut X, _: &Cell, rng: &mut impl Rng) -> Option<f64> {
            y.0 = (x.0 + 0.3 * (uniform(rng) - 0.5)).rem_euclid(1.0);
            Some(1.0)
        }
    }

    type Part = Accumulated<2, Tally>;

    /// From one byte that is damaged to the next: Miri takes seconds for each.
    const STEP: usize = if cfg!(miri) { 211 } else { 1 };

    fn key(seed: &str) -> Key {
        vec![("scene".into(), "line".into()), ("seed".into(), seed.into())]
    }

    fn empty(seed: &str) -> Part {
        Part::new(Film::new(3, 0.5)).with_key(key(seed))
    }

    fn part(rounds: Range<u64>) -> Part {
        let share = if cfg!(miri) { Share { mutations: 7, samples: 3 } } else { Share { mutations: 700, samples: 90 } };
        let strata = [(Cell { low: 0.0 }, share), (Cell { low: 0.5 }, share)];
        let (mixture, importance) = (Mixture::new(vec![Nudge]), |x: &X| 0.1 + x.0);
        let metropolis = Metropolis::new(&strata, &mixture, &importance, 7).expect("sound");
        let mut part = empty("7");
        render(&metropolis, rounds, &mut part, &mut |_, _| ControlFlow::Continue(()));
        part
    }

    #[test]
    fn parts_add_up_to_the_same_bytes_in_any_order() {
        let whole = part(0..23).to_bytes();
        let ranges = [0..4, 4..5, 5..16, 16..23];
        for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1]] {
            let mut merged = empty("7");
            for i in order {
                let bytes = part(ranges[i].clone()).to_bytes();
                merged.merge(&Part::from_bytes(&bytes).expect("sound")).expect("another part");
            }
            assert!(merged.to_bytes() == whole, "{order:?}");
            assert_eq!(merged.rounds().to_string(), "0 to 22");
        }
        assert!(part(0..22).to_bytes() != whole);
    }

    #[test]
    fn what_does_not_belong_together_is_refused_by_name() {
        let (mut a, b) = (part(0..4), part(3..6));
        assert_eq!(
            a.merge(&b).expect_err("overlap").to_string(),
            "both films hold the rounds 3, which would count twice"
        );
        let other = empty("8");
        assert!(
            a.merge(&other).expect_err("another seed").to_string().starts_with("seed is 7 in one and 8 in the other")
        );
        assert_eq!(a.to_bytes(), part(0..4).to_bytes(), "and nothing has changed");
    }

    #[test]
    fn a_render_goes_on_where_it_was() {
        let whole = part(0..9);
        let mut resumed = Part::from_bytes(&part(0..5).to_bytes()).expect("sound");
        resumed.merge(&part(5..9)).expect("another part");
        assert_eq!(resumed.tally(), whole.tally());
        assert_eq!(resumed.film().pixel(1), whole.film().pixel(1));
        assert_eq!(resumed.tally().mutations, ["nudge"]);
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let bytes = part(0..2).to_bytes();
        assert!(Part::from_bytes(&bytes).is_ok());
        for at in (0..bytes.len()).step_by(STEP) {
            assert!(Part::from_bytes(&bytes[..at]).is_err(), "the first {at} bytes");
            for flip in [1, 128] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                assert!(Part::from_bytes(&damaged).is_err(), "byte {at} ^ {flip}");
            }
        }
        let longer: Vec<u8> = bytes.iter().copied().chain([0]).collect();
        assert!(Part::from_bytes(&longer).is_err());
        assert_eq!(Accumulated::<3, Tally>::from_bytes(&bytes).err(), Some(DecodeError::Channels(2)));
        let version = |number: u8| {
            let mut other = bytes.clone();
            other[8] = number;
            Part::from_bytes(&other).err()
        };
        assert_eq!(version(9), Some(DecodeError::Version(9)));
        assert_eq!(Part::from_bytes(b"not ours").err(), Some(DecodeError::Foreign));
    }

    /// Bytes whose checksum is right: what decodes has to hold against intent too.
    #[test]
    fn forged_bytes_make_no_panic() {
        let bytes = part(0..2).to_bytes();
        let content = &bytes[..bytes.len() - blake3::OUT_LEN];
        for at in (16..content.len()).step_by(STEP) {
            for value in [0, 1, 127, 255] {
                let mut forged = content.to_vec();
                forged[at] = value;
                let sum = checksum(&forged);
                forged.extend(sum);
                let _ = Part::from_bytes(&forged).map(|part| (part.film().whole([1.0; 2]), part.tally().warnings()));
            }
        }
    }
}
