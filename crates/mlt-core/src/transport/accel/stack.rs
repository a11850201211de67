//! The stack of a walk through the tree.
//!
//! **What is unsafe** here is to leave its array uninitialised: it is longer than most walks are.
#![allow(unsafe_code, reason = "memory that is not initialised")]

use std::mem::MaybeUninit;

/// Levels of trees that need no memory from the heap.
const LOCAL_LEVELS: usize = 32;

/// Levels of the tree above the current one; whole cache lines of its own.
#[repr(align(64))]
pub(super) struct Stack<T> {
    /// The first `len` are initialised, as far as there are so many.
    local: [MaybeUninit<T>; LOCAL_LEVELS],
    /// Those beyond them.
    heap: Vec<T>,
    len: usize,
}

impl<T: Copy> Stack<T> {
    /// An empty stack for a tree of some depth.
    #[inline(always)]
    pub(super) fn new(depth: usize) -> Self {
        let heap = if depth <= LOCAL_LEVELS { Vec::new() } else { Vec::with_capacity(depth) };
        Self { local: [const { MaybeUninit::uninit() }; LOCAL_LEVELS], heap, len: 0 }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, entry: T) {
        match self.local.get_mut(self.len) {
            Some(slot) => _ = slot.write(entry),
            None => self.heap.push(entry),
        }
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        match self.local.get(self.len) {
            // SAFETY: it lay below the old `len`, and `push` has written all of those.
            Some(slot) => Some(unsafe { slot.assume_init() }),
            None => self.heap.pop(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_pushed_last_is_popped_first() {
        for depth in [0, 1, LOCAL_LEVELS, LOCAL_LEVELS + 1, 3 * LOCAL_LEVELS] {
            let mut stack = Stack::new(depth);
            for _ in 0..2 {
                (0..depth).for_each(|level| stack.push(level));
                assert!((0..depth).rev().all(|level| stack.pop() == Some(level)));
                assert_eq!(stack.pop(), None);
            }
        }
    }
}
