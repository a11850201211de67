//! Which vector instructions the processor has, and work that is compiled for them.
//!
//! **What is unsafe** here is to call code compiled for AVX2.
#![allow(unsafe_code, reason = "calls of code compiled for AVX2")]

/// Plain Rust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

/// Proof that the processor has AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// Asks the processor.
    fn detect() -> Option<Self> {
        let all = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        all.then_some(Self(()))
    }
}

/// The instruction set to use, chosen once.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InstructionSet {
    /// Any processor.
    Portable(Portable),
    /// x86-64 since 2013.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

/// Code that may be compiled for each instruction set.
pub(crate) trait Work {
    /// Type of its result.
    type Outcome;

    /// Does it. Implementations are `#[inline(always)]`, as is what they call where it shall be compiled so too.
    fn perform(self) -> Self::Outcome;
}

impl InstructionSet {
    /// The best that this processor has.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::detect() {
            return Self::Avx2(avx2);
        }
        Self::Portable(Portable)
    }

    /// Does `work` with these instructions: to the same bits, since the compiler fuses nothing that is not written fused.
    #[inline(always)]
    pub(crate) fn perform<W: Work>(self, work: W) -> W::Outcome {
        match self {
            Self::Portable(_) => work.perform(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a value of `Avx2` exists only where the processor has all the features that are enabled.
            Self::Avx2(_) => unsafe { perform_avx2(work) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn perform_avx2<W: Work>(work: W) -> W::Outcome {
    work.perform()
}
