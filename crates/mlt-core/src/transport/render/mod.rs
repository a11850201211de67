//! A whole render: a method, its settings, and what it counted.

mod features;

use crate::engine::{Ending, Outcome, Standing, Watch};
use crate::transport::methods::auto::{Auto, Plan, Summary};
use crate::transport::methods::metropolis::PathMetropolis;
use crate::transport::methods::primary::{Mmlt, Pssmlt};
use crate::transport::methods::{BidirectionalTracing, PathTracing, Run};
use crate::transport::scene::View;
use std::ops::{ControlFlow, Range};

pub use crate::transport::methods::{Counts, Method, Observer, PilotCounts, Settings, Sums, film_of, film_unit};
pub use features::{NOWHERE, SurfaceFeatures, strongest_strata, surfaces};

/// A method that is set up for a view.
#[derive(Debug)]
pub struct Renderer<'a> {
    view: View<'a>,
    method: Prepared<'a>,
}

/// A method with all that its rounds need.
#[derive(Debug)]
enum Prepared<'a> {
    Auto(Auto<'a>),
    Metropolis(PathMetropolis<'a>),
    Pssmlt(Pssmlt<'a>),
    Mmlt(Mmlt<'a>),
    Bidirectional(BidirectionalTracing<'a>),
    Path(PathTracing<'a>),
}

impl<'a> Renderer<'a> {
    /// Sets a render up. The pilot, if its method has one, runs here.
    pub fn new(view: View<'a>, settings: Settings) -> Self {
        Self::watched(view, settings, Watch::NEVER).expect("nothing stops it")
    }

    /// The same with a pilot that can be stopped; then there is no renderer.
    pub fn watched(view: View<'a>, settings: Settings, watch: Watch) -> Option<Self> {
        let method = match settings.method {
            Method::Auto => Prepared::Auto(Auto::new(view, settings, watch)?),
            Method::Metropolis => Prepared::Metropolis(PathMetropolis::new(view, settings, watch)?),
            Method::PrimaryBidirectional => Prepared::Pssmlt(Pssmlt::new(view, settings, watch)?),
            Method::Multiplexed => Prepared::Mmlt(Mmlt::new(view, settings, watch)?),
            Method::Bidirectional => Prepared::Bidirectional(BidirectionalTracing::new(view, settings)),
            Method::Path => Prepared::Path(PathTracing::new(view, settings)),
        };
        Some(Self { view, method })
    }

    /// A render with [`Method::Auto`] that follows a plan of the caller's.
    pub fn with_plan(view: View<'a>, settings: Settings, plan: Plan) -> Self {
        Self { view, method: Prepared::Auto(Auto::with_plan(view, settings, plan)) }
    }

    /// Decision of [`Method::Auto`].
    pub fn decision(&self) -> Option<&Summary> {
        match &self.method {
            Prepared::Auto(auto) => Some(auto.decision()),
            _ => None,
        }
    }

    /// Sums without any round, for this image.
    pub fn sums(&self) -> Sums {
        Sums::new(film_of(self.view))
    }

    /// Makes rounds from number `first` on until the end, on the current rayon pool; see [`Ending::render`].
    pub fn render_until(
        &self,
        ending: &Ending<3>,
        first: u64,
        sums: &mut Sums,
        observe: &mut dyn FnMut(Standing, &Sums) -> ControlFlow<()>,
    ) -> Outcome {
        ending.render(first, sums, &|rounds, sums, observe| self.render(rounds, sums, observe), observe)
    }

    /// Adds rounds to `sums`, on the current rayon pool. Those that are in them already are left out.
    pub fn render(&self, rounds: Range<u64>, sums: &mut Sums, observe: &mut Observer) -> Outcome {
        let run = Run { rounds, sums, observe };
        match &self.method {
            Prepared::Auto(method) => method.render(run),
            Prepared::Metropolis(method) => method.render(run),
            Prepared::Pssmlt(method) => method.render(run),
            Prepared::Mmlt(method) => method.render(run),
            Prepared::Bidirectional(method) => method.render(run),
            Prepared::Path(method) => method.render(run),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::colour::Rgb;
    use crate::transport::image::Target;
    use crate::transport::lights::Stratification;
    use crate::transport::tests::worlds::{lambert, room};
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Whether a pilot that is stopped when it asks for the `last`-th time gives a renderer, and how often it has asked.
    fn watched(settings: &Settings, last: u64) -> (bool, u64) {
        let (world, asked) = (room(lambert(Rgb::splat(0.5)), false), AtomicU64::new(0));
        let go_on = || match asked.fetch_add(1, Ordering::Relaxed) + 1 < last {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        let renderer = Renderer::watched(world.view(), settings.clone(), Watch::new(&go_on));
        (renderer.is_some(), asked.load(Ordering::Relaxed))
    }

    #[test]
    fn a_pilot_can_be_stopped_at_any_time() {
        let of = |method, change: fn(&mut Settings)| Settings::new(method, 1.0).with(change);
        for settings in [
            of(Method::Auto, |_| ()),
            of(Method::Metropolis, |_| ()),
            of(Method::Metropolis, |s| s.stratification = Stratification::Grid(2, 2)),
            of(Method::Metropolis, |s| s.stratification = Stratification::Auto),
            of(Method::Metropolis, |s| s.target = Target::Relative),
            of(Method::PrimaryBidirectional, |_| ()),
            of(Method::Multiplexed, |_| ()),
        ] {
            let (made, all) = watched(&settings, u64::MAX);
            assert!(made && all > 0, "{settings:?}");
            for last in [1, all.div_ceil(2), all] {
                let (made, asked) = watched(&settings, last);
                // Threads that ask at the same time may each be told.
                assert!(!made && asked < last + 64, "{settings:?}: stopped at {last} of {all}, asked {asked} times");
            }
        }
    }
}
