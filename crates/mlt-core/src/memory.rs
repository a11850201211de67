//! A budget of memory that all who allocate much of it share.

use std::{
    error::Error,
    fmt,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

/// Bytes that may still be allocated.
///
/// Whoever is about to allocate in proportion to its input takes what that will need first, and so refuses the input by an
/// error instead of being ended by the system.
#[derive(Debug)]
pub struct Memory {
    total: u64,
    left: AtomicU64,
}

/// More was asked for than is left; the message goes on from what asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortage {
    /// Bytes asked for.
    pub needed: u64,
    /// Bytes that are left.
    pub left: u64,
}

impl Error for Shortage {}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "needs {} of memory and {} are available", Size(self.needed), Size(self.left))
    }
}

impl Memory {
    /// A budget of so many bytes.
    pub fn of(bytes: u64) -> Self {
        Self { total: bytes, left: AtomicU64::new(bytes) }
    }

    /// A budget that refuses nothing.
    pub fn unlimited() -> Self {
        Self::of(u64::MAX)
    }

    /// Bytes that there were in the beginning.
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Bytes that are set aside.
    pub fn taken(&self) -> u64 {
        self.total - self.left.load(Relaxed)
    }

    /// Sets bytes aside for good.
    ///
    /// # Errors
    /// If fewer are left.
    pub fn take(&self, bytes: u64) -> Result<(), Shortage> {
        let taken = self.left.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(bytes));
        taken.map(|_| ()).map_err(|left| Shortage { needed: bytes, left })
    }

    /// Whether so many bytes are left for what is soon freed.
    ///
    /// # Errors
    /// If fewer are left.
    pub fn check(&self, bytes: u64) -> Result<(), Shortage> {
        let left = self.left.load(Relaxed);
        if bytes > left { Err(Shortage { needed: bytes, left }) } else { Ok(()) }
    }
}

/// Bytes, in the unit that suits them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        const GIB: u64 = 1 << 30;
        let (unit, name) = if self.0 < GIB { (GIB >> 10, "MiB") } else { (GIB, "GiB") };
        write!(f, "{:.1} {name}", self.0 as f64 / unit as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_no_longer_left() {
        let memory = Memory::of(10 << 20);
        assert_eq!(memory.take(6 << 20), Ok(()));
        assert_eq!((memory.check(4 << 20), memory.taken()), (Ok(()), 6 << 20));
        let refused = memory.take(5 << 20).unwrap_err();
        assert_eq!(refused.to_string(), "needs 5.0 MiB of memory and 4.0 MiB are available");
        assert_eq!(memory.take(4 << 20), Ok(()), "a refusal takes nothing");
        assert_eq!(
            memory.check(1 << 40).unwrap_err().to_string(),
            "needs 1024.0 GiB of memory and 0.0 MiB are available"
        );
        assert_eq!(Memory::unlimited().take(1 << 60), Ok(()));
    }
}
