//! A way to stop what makes no rounds.

use std::fmt;
use std::ops::ControlFlow;

/// Asked by a pilot, which has no [`Observer`](super::Observer), after each piece of work: it breaks to stop the pilot.
#[derive(Clone, Copy)]
pub struct Watch<'a>(&'a (dyn Fn() -> ControlFlow<()> + Sync));

impl<'a> Watch<'a> {
    /// Stops nothing.
    pub const NEVER: Watch<'static> = Watch(&|| ControlFlow::Continue(()));

    /// Asks `go_on`, from any thread.
    pub fn new(go_on: &'a (dyn Fn() -> ControlFlow<()> + Sync)) -> Self {
        Self(go_on)
    }

    /// Breaks where it is told to stop.
    pub(crate) fn go_on(self) -> ControlFlow<()> {
        (self.0)()
    }

    /// Does a piece of work, unless it is told to stop.
    pub(crate) fn unless_stopped<T>(self, work: impl FnOnce() -> T) -> Option<T> {
        self.go_on().is_continue().then(work)
    }
}

impl fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Watch")
    }
}
