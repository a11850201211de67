//! Eight floats at a time: AVX2, or a portable twin with the same bits.
//!
//! An instruction set is a value of a type that implements [`Simd`]. A value of [`Avx2`] exists only where the processor
//! has the instructions, so having one is the proof that calling them is sound. Where AVX2 fuses a multiplication and
//! an addition, [`Portable`] calls [`f32::mul_add`]; min and max follow x86 (the second operand if either is NaN).
#![allow(unsafe_code, reason = "vector instructions")]

#[cfg(target_arch = "x86_64")]
use crate::instructions::Avx2;
use crate::instructions::{InstructionSet, Portable};
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Eight floats in memory.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes(pub [f32; 8]);

/// Arithmetic on eight lanes; every operation but the fused ones rounds once a lane.
pub(super) trait Simd: Copy {
    /// Eight floats in a register.
    type Floats: Copy;
    /// Eight truth values.
    type Mask: Copy;
    /// Eight keys: see [`keys`](Self::keys).
    type Keys: Copy;

    /// The instruction set that this is.
    fn set(self) -> InstructionSet;
    /// Asks for memory ahead of its use; any address will do.
    fn prefetch<T>(self, _address: *const T) {}
    /// x in every lane.
    fn splat(self, x: f32) -> Self::Floats;
    /// From memory.
    fn load(self, lanes: &Lanes) -> Self::Floats;
    /// To memory.
    fn store(self, a: Self::Floats) -> Lanes;
    /// a + b
    fn add(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a − b
    fn sub(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a · b
    fn mul(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a / b
    fn div(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a < b ? a : b
    fn min(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a > b ? a : b
    fn max(self, a: Self::Floats, b: Self::Floats) -> Self::Floats;
    /// a · b + c, fused
    fn mul_add(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats;
    /// a · b − c, fused
    fn mul_sub(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats;
    /// c − a · b, fused
    fn neg_mul_add(self, a: Self::Floats, b: Self::Floats, c: Self::Floats) -> Self::Floats;
    /// a < b, false for NaN
    fn lt(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    /// a ≤ b, false for NaN
    fn le(self, a: Self::Floats, b: Self::Floats) -> Self::Mask;
    /// Both.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Either.
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Lane i's truth in bit i.
    fn bits(self, mask: Self::Mask) -> u32;

    /// Where the mask is true, the bits of a float ≥ 0 with the lane's number in the last three; elsewhere `u32::MAX`.
    /// Keys order as the floats do, and no two are the same.
    fn keys(self, a: Self::Floats, mask: Self::Mask) -> Self::Keys;
    /// The smallest of them.
    fn least(self, keys: Self::Keys) -> u32;
    /// Without those equal to `key`: `u32::MAX` in their place.
    fn without(self, keys: Self::Keys, key: u32) -> Self::Keys;
}

/// The bits of a [key](Simd::keys) that are its lane.
pub(super) const KEY_LANE: u32 = 7;

/// Each x in every lane of its own register; `map` over an array would not be inlined.
#[inline(always)]
pub(super) fn splat3<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [S::Floats; 3] {
    [simd.splat(x), simd.splat(y), simd.splat(z)]
}

#[inline(always)]
fn each(f: impl Fn(usize) -> f32) -> Lanes {
    Lanes(std::array::from_fn(f))
}

#[inline(always)]
fn where_true(f: impl Fn(usize) -> bool) -> u32 {
    (0..8).fold(0, |bits, i| bits | u32::from(f(i)) << i)
}

#[rustfmt::skip]
impl Simd for Portable {
    type Floats = Lanes;
    type Mask = u32;
    type Keys = [u32; 8];

    fn set(self) -> InstructionSet { InstructionSet::Portable(self) }
    fn splat(self, x: f32) -> Lanes { Lanes([x; 8]) }
    fn load(self, lanes: &Lanes) -> Lanes { *lanes }
    fn store(self, a: Lanes) -> Lanes { a }
    fn add(self, a: Lanes, b: Lanes) -> Lanes { each(|i| a.0[i] + b.0[i]) }
    fn sub(self, a: Lanes, b: Lanes) -> Lanes { each(|i| a.0[i] - b.0[i]) }
    fn mul(self, a: Lanes, b: Lanes) -> Lanes { each(|i| a.0[i] * b.0[i]) }
    fn div(self, a: Lanes, b: Lanes) -> Lanes { each(|i| a.0[i] / b.0[i]) }
    fn min(self, a: Lanes, b: Lanes) -> Lanes { each(|i| if a.0[i] < b.0[i] { a.0[i] } else { b.0[i] }) }
    fn max(self, a: Lanes, b: Lanes) -> Lanes { each(|i| if a.0[i] > b.0[i] { a.0[i] } else { b.0[i] }) }
    fn mul_add(self, a: Lanes, b: Lanes, c: Lanes) -> Lanes { each(|i| a.0[i].mul_add(b.0[i], c.0[i])) }
    fn mul_sub(self, a: Lanes, b: Lanes, c: Lanes) -> Lanes { each(|i| a.0[i].mul_add(b.0[i], -c.0[i])) }
    fn neg_mul_add(self, a: Lanes, b: Lanes, c: Lanes) -> Lanes { each(|i| (-a.0[i]).mul_add(b.0[i], c.0[i])) }
    fn lt(self, a: Lanes, b: Lanes) -> u32 { where_true(|i| a.0[i] < b.0[i]) }
    fn le(self, a: Lanes, b: Lanes) -> u32 { where_true(|i| a.0[i] <= b.0[i]) }
    fn and(self, a: u32, b: u32) -> u32 { a & b }
    fn or(self, a: u32, b: u32) -> u32 { a | b }
    fn bits(self, mask: u32) -> u32 { mask }
    fn keys(self, a: Lanes, mask: u32) -> [u32; 8] {
        std::array::from_fn(|i| if mask >> i & 1 == 1 { a.0[i].to_bits() & !KEY_LANE | i as u32 } else { u32::MAX })
    }
    fn least(self, keys: [u32; 8]) -> u32 { keys.into_iter().fold(u32::MAX, u32::min) }
    fn without(self, keys: [u32; 8], key: u32) -> [u32; 8] { keys.map(|k| if k == key { u32::MAX } else { k }) }
}

/// Methods that are one expression of intrinsics each.
#[cfg(target_arch = "x86_64")]
macro_rules! intrinsics {
    ($($name:ident($($arg:ident: $kind:ty),*) -> $out:ty = $body:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: $kind),*) -> $out {
            // SAFETY: `self` proves that the processor has the instructions. The two that touch memory are given
            // a `Lanes`, which is 32 bytes long and 32-byte aligned.
            unsafe { $body }
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
impl Simd for Avx2 {
    type Floats = __m256;
    type Mask = __m256;
    type Keys = __m256i;

    fn set(self) -> InstructionSet {
        InstructionSet::Avx2(self)
    }

    #[inline(always)]
    fn prefetch<T>(self, address: *const T) {
        let mut at = 0;
        while at < size_of::<T>() {
            // SAFETY: prefetching never faults, whatever the address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(address.cast::<i8>().wrapping_add(at)) };
            at += 64;
        }
    }

    intrinsics! {
        splat(x: f32) -> __m256 = _mm256_set1_ps(x);
        load(lanes: &Lanes) -> __m256 = _mm256_load_ps(lanes.0.as_ptr());
        store(a: __m256) -> Lanes = {
            let mut lanes = Lanes([0.0; 8]);
            _mm256_store_ps(lanes.0.as_mut_ptr(), a);
            lanes
        };
        add(a: __m256, b: __m256) -> __m256 = _mm256_add_ps(a, b);
        sub(a: __m256, b: __m256) -> __m256 = _mm256_sub_ps(a, b);
        mul(a: __m256, b: __m256) -> __m256 = _mm256_mul_ps(a, b);
        div(a: __m256, b: __m256) -> __m256 = _mm256_div_ps(a, b);
        min(a: __m256, b: __m256) -> __m256 = _mm256_min_ps(a, b);
        max(a: __m256, b: __m256) -> __m256 = _mm256_max_ps(a, b);
        mul_add(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fmadd_ps(a, b, c);
        mul_sub(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fmsub_ps(a, b, c);
        neg_mul_add(a: __m256, b: __m256, c: __m256) -> __m256 = _mm256_fnmadd_ps(a, b, c);
        lt(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LT_OQ>(a, b);
        le(a: __m256, b: __m256) -> __m256 = _mm256_cmp_ps::<_CMP_LE_OQ>(a, b);
        and(a: __m256, b: __m256) -> __m256 = _mm256_and_ps(a, b);
        or(a: __m256, b: __m256) -> __m256 = _mm256_or_ps(a, b);
        bits(mask: __m256) -> u32 = _mm256_movemask_ps(mask) as u32;
        keys(a: __m256, mask: __m256) -> __m256i = {
            let distance = _mm256_andnot_si256(_mm256_set1_epi32(KEY_LANE as i32), _mm256_castps_si256(a));
            let key = _mm256_or_si256(distance, _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
            _mm256_blendv_epi8(_mm256_set1_epi32(-1), key, _mm256_castps_si256(mask))
        };
        least(keys: __m256i) -> u32 = {
            let four = _mm_min_epu32(_mm256_castsi256_si128(keys), _mm256_extracti128_si256::<1>(keys));
            let two = _mm_min_epu32(four, _mm_shuffle_epi32::<0b0100_1110>(four));
            _mm_cvtsi128_si32(_mm_min_epu32(two, _mm_shuffle_epi32::<0b1011_0001>(two))) as u32
        };
        without(keys: __m256i, key: u32) -> __m256i =
            _mm256_or_si256(keys, _mm256_cmpeq_epi32(keys, _mm256_set1_epi32(key as i32)));
    }
}
