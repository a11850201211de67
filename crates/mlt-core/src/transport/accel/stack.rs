//! The stack of a walk through the tree.
//!
//! **What is unsafe** here is to leave its array uninitialised: it is longer than most walks are.
#![allow(unsafe_code, reason = "memory that is not initialised")]

use std::mem::MaybeUninit;

/// Levels of trees that need no memory from the heap.
pub(super) const LOCAL_LEVELS: usize = 32;

/// Levels of the tree above the current one; whole cache lines of its own. A `LOCAL` one is for no more than [`LOCAL_LEVELS`].
#[repr(align(64))]
pub(super) struct Stack<T, const LOCAL: bool> {
    /// The first `len` are initialised, as far as there are so many.
    local: [MaybeUninit<T>; LOCAL_LEVELS],
    /// Those beyond them.
    heap: Vec<T>,
    len: usize,
}

impl<T: Copy, const LOCAL: bool> Stack<T, LOCAL> {
    /// An empty stack for a tree of some depth.
    #[inline(always)]
    pub(super) fn new(depth: usize) -> Self {
        let heap = if LOCAL { Vec::new() } else { Vec::with_capacity(depth.saturating_sub(LOCAL_LEVELS)) };
        Self { local: [const { MaybeUninit::uninit() }; LOCAL_LEVELS], heap, len: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, entry: T) {
        if LOCAL || self.len < LOCAL_LEVELS {
            self.local[self.len].write(entry);
        } else {
            self.heap.push(entry);
        }
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        if LOCAL || self.len < LOCAL_LEVELS {
            // SAFETY: it lay below the old `len`, and `push` has written all of those.
            Some(unsafe { self.local[self.len].assume_init() })
        } else {
            self.heap.pop()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const LOCAL: bool>(entries: usize) {
        let mut stack = Stack::<usize, LOCAL>::new(entries);
        (0..entries).for_each(|entry| stack.push(entry));
        assert!((0..entries).rev().all(|entry| stack.pop() == Some(entry)));
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn what_is_pushed_last_is_popped_first() {
        check::<true>(LOCAL_LEVELS);
        check::<false>(LOCAL_LEVELS);
        check::<false>(3 * LOCAL_LEVELS);
    }
}
