//! How light transport is computed.
//!
//! [`TransportOptions`] is read from the command line, makes the settings of the library, and is written into reports and image
//! files field by field: a new option is a field here and a line in [`TransportOptions::settings`].

use std::fmt;

use clap::{Args, ValueEnum, builder::PossibleValue};
use mlt_core::transport::{
    image::Target,
    methods::metropolis,
    render::{self, Settings},
};
use serde::{Serialize, Serializer};

use super::{heading, perturbations::PerturbationList, values::Strata};

/// How light transport is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Independent samples where they are better, Metropolis where it pays; a pilot decides
    Auto,
    /// Stratified Metropolis light transport
    Mlt,
    /// Bidirectional path tracing
    Bdpt,
    /// Path tracing
    #[value(alias = "path")]
    Pt,
    /// Stratified Metropolis over the random numbers of bidirectional samples
    Pssmlt,
    /// Stratified Metropolis over the random numbers of single paths, with their length and technique
    Mmlt,
}

impl Method {
    /// Whether it samples by chains of mutations; else by independent samples.
    pub fn mutates(self) -> bool {
        matches!(self, Self::Mlt | Self::Pssmlt | Self::Mmlt)
    }

    /// The unit of its work: `mutations` or `samples`.
    pub fn unit(self) -> &'static str {
        if self.mutates() { "mutations" } else { "samples" }
    }
}

/// As on the command line.
impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.to_possible_value().as_ref().map_or("", PossibleValue::get_name))
    }
}

impl From<Method> for render::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Auto => Self::Auto,
            Method::Mlt => Self::Metropolis,
            Method::Bdpt => Self::Bidirectional,
            Method::Pt => Self::Path,
            Method::Pssmlt => Self::PrimaryBidirectional,
            Method::Mmlt => Self::Multiplexed,
        }
    }
}

/// The scalar that chains sample in proportion to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Importance {
    /// Luminance of a path's contribution
    #[default]
    Luminance,
    /// The same over the image's luminance there, from a quick image: evens the relative error
    Relative,
}

/// How mutations are shared among strata.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// In proportion to the power of the strata's lights
    Power,
    /// By the noise and cost that pilot rounds measure
    #[default]
    Adaptive,
}

/// The chains or mutations that strata restrict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Chains stay in their strata
    #[default]
    Stratified,
    /// Only the bidirectional mutation stays in the stratum that it finds the path in
    MutationOnly,
}

/// Options that decide how the light of a scene is computed, besides method and budget.
#[derive(Args, Clone, Debug, PartialEq, Serialize)]
pub struct TransportOptions {
    /// Cut lights into strata: 'none', 'auto', a number of strata, or cells of each light, as in 4x4
    ///
    /// 'auto' is found by a pilot. Add ',length' and ',tiles:NxM' to cut by path length and over the image as well (mlt; auto, pssmlt
    /// and mmlt take the cut of lights alone).
    #[arg(long, value_name = "STRATA", default_value_t, help_heading = heading::RESEARCH, hide_short_help = true)]
    #[serde(rename = "strata_option")]
    pub strata: Strata,
    /// How mutations are shared among strata in mlt, pssmlt and mmlt; adaptive if not given
    #[arg(long, value_enum, help_heading = heading::RESEARCH, hide_short_help = true)]
    #[serde(serialize_with = "or_default")]
    pub weights: Option<Weights>,
    /// Rounds of each measurement of the pilot, for adaptive weights and automatic strata
    #[arg(long, value_name = "N", default_value_t = 4, help_heading = heading::RESEARCH, hide_short_help = true)]
    #[arg(value_parser = clap::value_parser!(u64).range(2..=64))]
    pub rounds_pilot: u64,
    /// Chains or mutations that strata restrict in mlt
    #[arg(long, value_enum, default_value_t, help_heading = heading::RESEARCH, hide_short_help = true)]
    pub variant: Variant,
    /// Perturbations beside the bidirectional mutation in mlt: 'all' that the scene has use for, 'none', or some of lens, multi-chain,
    /// pivot and caustic, with commas between them
    #[arg(long, value_name = "all|none|LIST", default_value_t, help_heading = heading::RESEARCH, hide_short_help = true)]
    pub perturbations: PerturbationList,
    /// Importance that chains sample in proportion to
    #[arg(long, value_enum, default_value_t, help_heading = heading::RESEARCH, hide_short_help = true)]
    pub importance: Importance,
    /// Longest path, in edges from light to lens; no limit if not given
    #[arg(long, value_name = "EDGES", value_parser = clap::value_parser!(u32).range(1..), help_heading = heading::METHOD)]
    #[arg(hide_short_help = true)]
    pub max_length: Option<u32>,
    /// Seed of the random numbers: same seed, same image
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = heading::METHOD)]
    #[arg(hide_short_help = true)]
    pub seed: u64,
}

/// Serialises the default where nothing is given.
fn or_default<T: Copy + Default + Serialize, S: Serializer>(value: &Option<T>, to: S) -> Result<S::Ok, S::Error> {
    value.unwrap_or_default().serialize(to)
}

impl TransportOptions {
    /// Whether they ask for something that only chains have.
    pub fn ask_for_chains(&self) -> bool {
        self.weights.is_some() || self.change_chains()
    }

    /// Whether chains with them are others than those without.
    pub fn change_chains(&self) -> bool {
        self.strata != Strata::default()
            || self.weights.unwrap_or_default() != Weights::default()
            || self.variant != Variant::default()
            || self.perturbations != PerturbationList::default()
            || self.importance != Importance::default()
    }

    /// Settings of the library, in rounds of so many mutations or samples a pixel.
    pub fn settings(&self, method: Method, per_pixel: f64) -> Settings {
        Settings::new(method.into(), per_pixel).with(|settings| {
            settings.stratification = self.strata.lights;
            settings.classes = self.strata.classes;
            settings.adaptation.weights = match self.weights.unwrap_or_default() {
                Weights::Power => metropolis::Weights::Power,
                Weights::Adaptive => metropolis::Weights::Adaptive,
            };
            settings.adaptation.pilot_rounds = self.rounds_pilot;
            settings.variant = match self.variant {
                Variant::Stratified => metropolis::Variant::Stratified,
                Variant::MutationOnly => metropolis::Variant::MutationOnly,
            };
            settings.perturbations = self.perturbations.0;
            settings.target = match self.importance {
                Importance::Luminance => Target::Luminance,
                Importance::Relative => Target::Relative,
            };
            settings.max_edges = self.max_length.map(|edges| edges as usize);
            settings.seed = self.seed;
        })
    }
}
