//! Report of a render.

mod decision;
pub mod features;
mod trust;

use std::{collections::BTreeMap, fmt};

use mlt_core::engine::HalfChains;
use serde::Serialize;

use crate::{
    args::transport::{Method, TransportOptions, Variant},
    args::values::Strata,
    kept::Spent,
    output::Frame,
    progress::short,
    provenance::CameraUsed,
};

pub use decision::Decision;
pub use trust::Trust;

/// JSON has no infinity and no NaN.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The report of `mlt render --json`, one object; [`Display`](fmt::Display) is the same for reading.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: String,
    /// The scene as named on the command line.
    pub scene: String,
    /// As named on the command line, or the one that suits the other options.
    pub method: Method,
    /// The options as given, or their defaults.
    #[serde(flatten)]
    pub transport: TransportOptions,
    /// The camera.
    pub camera: CameraUsed,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The larger image that it is a part of; `None`: a whole one.
    pub crop: Option<Frame>,
    /// Threads that were used.
    pub threads: usize,
    /// Number of the first round.
    pub first_round: u64,
    /// Rounds that are in the image.
    pub rounds: u64,
    /// True when the user stopped the render before its end.
    pub interrupted: bool,
    /// Time on the clock, s.
    pub seconds: f64,
    /// Processor time of all threads, s; `None` where the system does not say.
    pub cpu_seconds: Option<f64>,
    /// Metropolis–Hastings steps.
    pub mutations: u64,
    /// Independent samples: of the bootstrap, or of the whole method.
    pub samples: u64,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// Those of chains and of the samples that they start from.
    pub chain_rays: u64,
    /// Mutations of the pilot, not in `mutations`; they went into no image.
    pub pilot_mutations: u64,
    /// Rays of the pilot, not in `rays`.
    pub pilot_rays: u64,
    /// Share of proposals accepted.
    pub acceptance: Acceptance,
    /// By name of the mutation, the longest run of its proposals in a chain of which none was accepted.
    pub longest_rejection: BTreeMap<String, u64>,
    /// Mean luminance of the image.
    pub b: f64,
    /// Its standard error, from its scatter over rounds; infinite (`null` in JSON) after one round.
    pub b_stderr: f64,
    /// Each stratum; empty when the method has none.
    pub strata: Vec<StratumReport>,
    /// Estimated relative error of the image, a fraction; `None` when there were too few rounds to tell.
    pub relative_error: Option<f64>,
    /// How well the rounds agree; `None` without chains, when there were too few rounds to tell, and for a black image.
    pub agreement: Option<Agreement>,
    /// Figures that tell whether the error bars can be trusted.
    pub trust: Trust,
    /// Decision of the method `auto`; `None` for other methods.
    pub decision: Option<Decision>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Files written.
    pub outputs: Vec<String>,
}

/// Share of proposals accepted, 0…1.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Acceptance {
    /// By name of the mutation; `None` for one that was never proposed.
    #[serde(flatten)]
    pub mutations: BTreeMap<String, Option<f64>>,
    /// Of all mutations together; `None` without mutations.
    pub total: Option<f64>,
}

/// How well rounds agree in the block of the image where they differ most.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Potential scale reduction R̂ ≥ 1 of the rounds taken as chains; 1: they agree.
    pub r_hat: f64,
    /// Column and row of the block.
    pub block: [usize; 2],
    /// Columns and rows of blocks.
    pub blocks: [usize; 2],
    /// Independent samples that all rounds together are worth there.
    pub effective_samples: f64,
}

/// Effective samples that are too few to know how bright a block is, let alone its error.
const FEW_SAMPLES: f64 = 50.0;

impl Agreement {
    /// A warning if rounds disagree.
    pub fn warning(&self) -> Option<String> {
        let Self { r_hat, block: [x, y], blocks: [columns, rows], effective_samples } = self;
        (*effective_samples < FEW_SAMPLES).then(|| {
            format!(
                "rounds disagree (R-hat {r_hat:.2}) in column {} of {columns}, row {} of {rows}, of the image: they are worth \
                 {effective_samples:.0} independent samples there; render longer, or by another --method",
                x + 1,
                y + 1
            )
        })
    }
}

/// One stratum.
#[derive(Clone, Debug, Serialize)]
pub struct StratumReport {
    /// b_j = ∫_{Ω_j} I.
    pub b: f64,
    /// Standard error of `b`.
    pub b_stderr: f64,
    /// Whether its paths are those that only chance meets.
    pub met_by_chance: bool,
    /// Metropolis–Hastings steps in this stratum.
    pub mutations: u64,
    /// Longest run of them, in one chain, without an acceptance.
    pub longest_rejection: u64,
    /// Split-R̂ of the stratum's chains; `None` without two of them, or where all states have the same importance.
    pub r_hat: Option<f64>,
    /// Independent states that the chains are worth; `None` as for `r_hat`.
    pub effective_states: Option<f64>,
    /// The data that both are made from.
    #[serde(skip)]
    pub halves: HalfChains,
}

/// A quantity of any size, for reading.
fn number(x: f64) -> String {
    if !x.is_finite() {
        return "unknown".into();
    }
    if x == 0.0 || (1e-4..1e6).contains(&x) { format!("{x:.6}") } else { format!("{x:.3e}") }
}

/// Strata that the text lists; JSON has them all.
const STRATA_SHOWN: usize = 16;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_render(f)?;
        self.write_work(f)?;
        self.decision.as_ref().map_or(Ok(()), |decision| write!(f, "{decision}"))?;
        write!(f, "{}", self.acceptance)?;
        writeln!(f, "  b               {} ± {}", number(self.b), number(self.b_stderr))?;
        self.write_cut(f)?;
        self.write_strata(f)?;
        if let Some(error) = self.relative_error {
            writeln!(f, "  relative error  {:.2} %, estimated", error * 100.0)?;
        }
        if let Some(Agreement { r_hat, effective_samples, blocks: [columns, rows], .. }) = self.agreement {
            let samples = short(effective_samples);
            writeln!(
                f,
                "  rounds agree    R-hat {r_hat:.3}, {samples} effective samples, in the worst of {columns}x{rows} blocks"
            )?;
        }
        self.outputs.iter().try_for_each(|output| writeln!(f, "  written         {output}"))
    }
}

impl Report {
    /// Says how long the rounds took.
    pub fn set_time(&mut self, spent: Spent) {
        self.seconds = spent.clock.as_secs_f64();
        self.cpu_seconds = spent.processors.map(|time| time.as_secs_f64());
    }

    /// Which render it is of, and how long that took.
    fn write_render(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {}, strata {}, {}x{}, seed {}",
            self.scene, self.method, self.transport.strata, self.width, self.height, self.transport.seed
        )?;
        if let Some(Frame { size: [width, height], corner: [x, y] }) = self.crop {
            writeln!(f, "  crop            {x},{y},{},{} of {width}x{height}", x + self.width, y + self.height)?;
        }
        writeln!(f, "  camera          {}", self.camera)?;
        let threads = if self.threads == 1 { "thread" } else { "threads" };
        write!(f, "  time            {:.2} s, {} {threads}", self.seconds, self.threads)?;
        self.cpu_seconds.map_or(Ok(()), |cpu| write!(f, ", {cpu:.2} s of processor time"))?;
        write!(f, "\n  rounds          {}", self.rounds)?;
        if self.first_round > 0 {
            write!(f, " from number {}", self.first_round)?;
        }
        writeln!(f)
    }

    /// How much was done, and how fast.
    fn write_work(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let with_rate = |count: u64| {
            let count = count as f64;
            format!("{} ({} per second)", short(count), short(count / self.seconds.max(f64::MIN_POSITIVE)))
        };
        if self.mutations > 0 {
            writeln!(f, "  mutations       {}", with_rate(self.mutations))?;
        }
        writeln!(f, "  samples         {}", with_rate(self.samples))?;
        writeln!(f, "  rays            {}", with_rate(self.rays))?;
        if self.pilot_rays > 0 {
            writeln!(f, "  pilot           {} mutations, {} rays", self.pilot_mutations, self.pilot_rays)?;
        }
        Ok(())
    }

    /// How many strata there were, if a cut was asked for.
    fn write_cut(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (made, asked) = (self.strata.len(), self.transport.strata.lights.least());
        if made == 0 || self.transport.strata == Strata::default() {
            return Ok(());
        }
        write!(f, "  strata          {made}")?;
        if self.method == Method::Mlt && self.transport.variant == Variant::Stratified && made < asked {
            write!(
                f,
                " of the {asked} or more asked for: a round has no room for a useful chain in each, so they are joined"
            )?;
        }
        writeln!(f)
    }

    fn write_strata(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [StratumReport { r_hat: Some(r_hat), effective_states: Some(states), .. }] = self.strata[..] {
            return writeln!(f, "  chains agree    R-hat {r_hat:.3}, worth {} independent states", short(states));
        }
        if self.strata.len() < 2 {
            return Ok(());
        }
        for (j, stratum) in self.strata.iter().take(STRATA_SHOWN).enumerate() {
            let StratumReport { b, b_stderr, met_by_chance, mutations, r_hat, effective_states, .. } = stratum;
            write!(f, "  stratum {j:<6}  b {} ± {}, {mutations} mutations", number(*b), number(*b_stderr))?;
            if let (Some(r_hat), Some(states)) = (r_hat, effective_states) {
                write!(f, ", worth {} independent states, R-hat {r_hat:.3}", short(*states))?;
            }
            if *met_by_chance {
                write!(f, "; paths that only chance meets, such as light through glass, seen through glass")?;
            }
            writeln!(f)?;
        }
        match self.strata.len().saturating_sub(STRATA_SHOWN) {
            0 => Ok(()),
            more => writeln!(f, "  and {more} more strata, which --json lists"),
        }
    }
}

impl fmt::Display for Acceptance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(total) = self.total else { return Ok(()) };
        write!(f, "  acceptance      {:.1} %", total * 100.0)?;
        for (name, rate) in &self.mutations {
            rate.map_or(Ok(()), |rate| write!(f, ", {name} {:.1} %", rate * 100.0))?;
        }
        writeln!(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{perturbations::PerturbationList, transport::Importance};

    fn report() -> Report {
        let mutations = [("bidirectional".to_owned(), Some(0.25)), ("lens".to_owned(), None)].into();
        Report {
            version: "0.1.0".into(),
            scene: "cornell".into(),
            method: Method::Mlt,
            transport: TransportOptions {
                strata: "4x5".parse().expect("valid"),
                weights: None,
                rounds_pilot: 4,
                variant: Variant::Stratified,
                perturbations: PerturbationList::default(),
                importance: Importance::Luminance,
                max_length: None,
                seed: 7,
            },
            camera: CameraUsed { name: "eye".into(), origin: "by --camera".into(), lens: "pinhole".into() },
            width: 64,
            height: 48,
            crop: None,
            threads: 2,
            first_round: 0,
            rounds: 4,
            interrupted: false,
            seconds: 2.0,
            cpu_seconds: Some(3.9),
            mutations: 3_000_000,
            samples: 1000,
            rays: 9_000_000,
            chain_rays: 0,
            pilot_mutations: 100_000,
            pilot_rays: 400_000,
            acceptance: Acceptance { mutations, total: Some(0.25) },
            longest_rejection: [("bidirectional".to_owned(), 31)].into(),
            b: 0.5,
            b_stderr: 0.001,
            strata: vec![
                StratumReport {
                    b: 0.025,
                    b_stderr: 0.0001,
                    met_by_chance: false,
                    mutations: 150_000,
                    longest_rejection: 31,
                    r_hat: Some(1.012),
                    effective_states: Some(2100.0),
                    halves: HalfChains::default(),
                };
                20
            ],
            relative_error: Some(0.0213),
            agreement: Some(Agreement { r_hat: 1.2, block: [1, 0], blocks: [8, 8], effective_samples: 36.0 }),
            trust: Trust::default(),
            decision: None,
            warnings: vec!["textures are left out".into()],
            outputs: vec!["a.exr".into()],
        }
    }

    #[test]
    fn json_has_the_promised_fields() {
        let json = serde_json::to_value(report()).expect("serialised");
        for name in [
            "scene",
            "method",
            "strata_option",
            "weights",
            "rounds_pilot",
            "variant",
            "perturbations",
            "seed",
            "threads",
            "rounds",
            "seconds",
            "cpu_seconds",
            "mutations",
            "samples",
            "rays",
            "b",
            "relative_error",
            "agreement",
            "warnings",
            "outputs",
        ] {
            assert!(!json[name].is_null(), "{name}");
        }
        assert_eq!((&json["strata_option"], &json["weights"]), (&"4x5".into(), &"adaptive".into()));
        assert_eq!(json["acceptance"]["total"], 0.25);
        assert_eq!(json["acceptance"]["bidirectional"], 0.25);
        assert!(json["acceptance"]["lens"].is_null());
        assert_eq!(json["strata"][19]["b_stderr"], 0.0001);
        assert_eq!(json["strata"][0]["mutations"], 150_000);
        assert_eq!(
            (&json["strata"][0]["longest_rejection"], &json["longest_rejection"]["bidirectional"]),
            (&31.into(), &31.into())
        );
    }

    #[test]
    fn rounds_that_disagree_are_told_of() {
        let agreement = report().agreement.expect("known");
        let warning = agreement.warning().expect("few samples");
        assert!(warning.contains("R-hat 1.20") && warning.contains("column 2 of 8, row 1 of 8"), "{warning}");
        assert_eq!(Agreement { effective_samples: 51.0, ..agreement }.warning(), None);
    }

    #[test]
    fn strata_that_were_joined_are_told() {
        let mut joined = report();
        joined.strata.truncate(6);
        assert!(joined.to_string().contains("  strata          6 of the 20 or more asked for: a round has no room"));
        joined.transport.strata = Strata::default();
        assert!(!joined.to_string().contains("\n  strata "));
    }

    #[test]
    fn the_text_is_for_reading() {
        let crop = Some(Frame { size: [640, 480], corner: [100, 50] });
        let text = Report { crop, ..report() }.to_string();
        for part in [
            "cornell: mlt, strata 4x5, 64x48, seed 7",
            "crop            100,50,164,98 of 640x480\n",
            "camera          \"eye\", by --camera; pinhole\n",
            "pilot           100000 mutations, 400000 rays",
            "mutations       3.00 million (1.50 million per second)",
            "acceptance      25.0 %, bidirectional 25.0 %\n",
            "b               0.500000 ± 0.001000",
            "150000 mutations, worth 2100 independent states, R-hat 1.012",
            "  strata          20\n",
            "and 4 more strata",
            "relative error  2.13 %, estimated",
            "written         a.exr",
        ] {
            assert!(text.contains(part), "{part} is not in:\n{text}");
        }
    }
}
