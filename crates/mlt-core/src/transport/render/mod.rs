//! A whole render: a method, its settings, and what it counted.

mod features;

use crate::engine::{DecodeError, Ending, Outcome, Standing, Watch, put, sealed, unsealed};
use crate::transport::methods::auto::{Auto, Plan, Summary};
use crate::transport::methods::metropolis::PathMetropolis;
use crate::transport::methods::primary::{Mmlt, Pssmlt};
use crate::transport::methods::{BidirectionalTracing, PathTracing, Run};
use crate::transport::scene::View;
use std::ops::{ControlFlow, Range};

pub use crate::transport::methods::{Counts, Method, Observer, PilotCounts, Settings, Sums, film_of, film_unit};
pub use features::{NOWHERE, SurfaceFeatures, strongest_strata, surfaces};

/// First bytes of what a pilot found.
const MAGIC: [u8; 8] = *b"mlt-plan";
/// Version of their format.
const VERSION: u32 = 3;

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

    /// Sets a render up that goes on, or shares the work: `pilot` is what [`pilot`](Self::pilot) gave in another render of the same view with
    /// the same settings, and its rounds have the same bits as if the pilot had been run again.
    ///
    /// # Errors
    ///
    /// If the bytes are of something else, of another version or damaged, or do not fit view and settings.
    pub fn following(view: View<'a>, settings: Settings, pilot: &[u8]) -> Result<Self, DecodeError> {
        unsealed(pilot, MAGIC, VERSION, |from| {
            let of = settings.method;
            if from.number()? != of as u64 {
                return Err(DecodeError::Foreign);
            }
            let method = match of {
                Method::Auto => Prepared::Auto(Auto::following(view, settings, from)?),
                Method::Metropolis => Prepared::Metropolis(PathMetropolis::following(view, settings, from)?),
                Method::PrimaryBidirectional => Prepared::Pssmlt(Pssmlt::following(view, settings, from)?),
                Method::Multiplexed => Prepared::Mmlt(Mmlt::following(view, settings, from)?),
                Method::Bidirectional | Method::Path => return Err(DecodeError::Foreign),
            };
            Ok(Self { view, method })
        })
    }

    /// The pilot's outcome, for [`following`](Self::following); nothing where the method has no pilot.
    pub fn pilot(&self) -> Option<Vec<u8>> {
        let (method, found) = match &self.method {
            Prepared::Auto(method) => (Method::Auto, method.pilot()),
            Prepared::Metropolis(method) => (Method::Metropolis, method.pilot()),
            Prepared::Pssmlt(method) => (Method::PrimaryBidirectional, method.pilot()),
            Prepared::Mmlt(method) => (Method::Multiplexed, method.pilot()),
            Prepared::Bidirectional(_) | Prepared::Path(_) => return None,
        };
        Some(sealed(MAGIC, VERSION, |to| {
            put(to, method as u64);
            to.extend(found);
        }))
    }

    /// A render with [`Method::Auto`] that follows a plan of the caller's.
    ///
    /// # Panics
    ///
    /// In a round, if the plan has not as many shares as [`Plan::new`] asks for.
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

    /// Number of the stratum of what only chance meets, where that is one of its own.
    pub fn met_by_chance(&self) -> Option<usize> {
        match &self.method {
            Prepared::Auto(method) => method.met_by_chance(),
            Prepared::Metropolis(method) => method.met_by_chance(),
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
    use crate::transport::tests::worlds::{lambert, pond, room};
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

    /// Settings with pilots of all kinds.
    fn with_pilots() -> [Settings; 7] {
        let of = |method, change: fn(&mut Settings)| Settings::new(method, 1.0).with(change);
        [
            of(Method::Auto, |_| ()),
            of(Method::Metropolis, |_| ()),
            of(Method::Metropolis, |s| s.stratification = Stratification::Grid(2, 2)),
            of(Method::Metropolis, |s| s.stratification = Stratification::Auto),
            of(Method::Metropolis, |s| s.target = Target::Relative),
            of(Method::PrimaryBidirectional, |_| ()),
            of(Method::Multiplexed, |_| ()),
        ]
    }

    fn two_rounds(renderer: &Renderer) -> Vec<u8> {
        let mut sums = renderer.sums();
        renderer.render(0..2, &mut sums, &mut |_, _| ControlFlow::Continue(()));
        sums.to_bytes()
    }

    #[test]
    fn what_a_pilot_found_takes_its_place() {
        for (world, settings) in [room(lambert(Rgb::splat(0.5)), false), pond()]
            .iter()
            .flat_map(|world| with_pilots().map(|settings| (world, settings)))
        {
            let first = Renderer::new(world.view(), settings.clone());
            let pilot = first.pilot().expect("a pilot");
            let second = Renderer::following(world.view(), settings.clone(), &pilot).expect("sound");
            assert!(two_rounds(&first) == two_rounds(&second), "{settings:?}");
            assert_eq!(second.pilot(), Some(pilot.clone()));
            assert_eq!(first.decision(), second.decision());
            // The control: what another seed's pilot found is followed as well, and is something else.
            let other = Renderer::new(world.view(), settings.clone().with(|s| s.seed = 1)).pilot().expect("a pilot");
            let third = Renderer::following(world.view(), settings.clone(), &other).expect("sound");
            assert!(two_rounds(&third) != two_rounds(&second) || other == pilot, "{settings:?}");
        }
        let world = room(lambert(Rgb::splat(0.5)), false);
        assert_eq!(Renderer::new(world.view(), Settings::new(Method::Path, 1.0)).pilot(), None);
    }

    #[test]
    fn a_pilot_s_bytes_are_not_trusted() {
        let world = pond();
        for settings in with_pilots().into_iter().filter(|settings| settings.target == Target::Luminance) {
            let read = |bytes: &[u8]| Renderer::following(world.view(), settings.clone(), bytes).map(|_| ());
            let pilot = Renderer::new(world.view(), settings.clone()).pilot().expect("a pilot");
            let content = &pilot[12..pilot.len() - 32];
            for at in 0..pilot.len() {
                assert!(read(&pilot[..at]).is_err(), "{settings:?}: the first {at} bytes");
                let mut damaged = pilot.clone();
                damaged[at] ^= 1;
                assert!(read(&damaged).is_err(), "{settings:?}: byte {at}");
            }
            // Bytes whose checksum is right make no panic, and a share of all numbers is refused.
            for (at, value) in (0..content.len()).flat_map(|at| [0, 1, 127, 255].map(|value| (at, value))) {
                let forged = |to: &mut Vec<u8>| {
                    to.extend(content);
                    to[12 + at] = value;
                };
                let _ = read(&sealed(MAGIC, VERSION, forged));
            }
            assert_eq!(read(&sealed(MAGIC, VERSION, |to| to.extend([0xff; 64]))), Err(DecodeError::Foreign));
            let other = Settings::new(Method::Path, 1.0);
            assert!(Renderer::following(world.view(), other, &pilot).is_err());
        }
    }

    #[test]
    fn a_pilot_can_be_stopped_at_any_time() {
        for settings in with_pilots() {
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
