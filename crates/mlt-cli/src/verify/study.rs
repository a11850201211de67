//! Makes replicas: many short renders with different seeds.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mlt_core::transport::Rgb;
use mlt_core::transport::scene::{Punctual, SceneDescription};
use rayon::prelude::*;

use super::{
    errors::rel_mse,
    evidence::{Evidence, Group, Replica},
};
use crate::{
    Failure,
    args::{contestant::Contestant, render::RenderOptions, scene::SceneOptions, transport::Method, values::Size},
    bench::statistics::mean_of,
    interrupt::Interrupt,
    render::{self, Plan, Setup},
};

/// Most groups of lights that the reference renders apart.
const MOST_GROUPS: usize = 8;
/// Fewest rounds of a replica whose number is not given: one round says nothing of its error.
const FEWEST_ROUNDS: u64 = 4;
/// How far lights move between two frames, in sizes of the scene.
const NUDGE: f64 = 1e-6;
/// The reference's seeds start here, beyond those of the methods.
const REFERENCE_SEEDS: u64 = 1 << 32;

/// How much is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Size of the images.
    pub size: Size,
    /// Renders of each method.
    pub replicas: u64,
    /// Mutations per pixel of each; other methods take as many as cost about the same. `None`: what a render takes by itself.
    pub per_pixel: Option<f64>,
    /// Rounds of each; `None`: as many as a render makes by itself.
    pub rounds: Option<u64>,
    /// The first seed.
    pub seed: u64,
}

impl Effort {
    /// Everything that decides the images.
    pub fn identity(&self) -> String {
        let Self { size, replicas, per_pixel, rounds, seed } = self;
        let budget = per_pixel.map_or("the usual budget".into(), |n| format!("{n} per pixel"));
        let rounds = rounds.map_or("the usual rounds".into(), |n| format!("{n} rounds"));
        format!("{size}, {replicas} replicas of {budget} in {rounds}, seeds from {seed}")
    }

    /// Mutations or samples a pixel of this method, and rounds, as options of a render.
    fn options_of(&self, method: Method) -> Vec<String> {
        let budget = self.per_pixel.map(|_| Plan::budget_option(method, self.per_pixel_of(method), 1));
        let budget = budget.iter().flat_map(|option| option.split_whitespace().map(str::to_owned));
        budget.chain(self.rounds.map(|rounds| format!("--rounds={rounds}"))).collect()
    }

    /// Mutations or samples a pixel of this method, enough for one a round.
    fn per_pixel_of(&self, method: Method) -> f64 {
        let Some(per_pixel) = self.per_pixel else { return Plan::usual(method) };
        let cost = match method {
            Method::Bdpt | Method::Pssmlt => 8.0,
            Method::Auto | Method::Pt | Method::Mmlt => 2.0,
            _ => 1.0,
        };
        (per_pixel / cost).max(self.rounds.unwrap_or(FEWEST_ROUNDS) as f64)
    }
}

/// A scene, with its lights apart.
#[derive(Debug)]
pub struct Subject {
    scene: PathBuf,
    effort: Effort,
    setup: Setup,
    /// The scene by some of its lights alone, and their material's name.
    groups: Vec<(String, Setup)>,
    /// The scene with its lights moved a little.
    moved: Setup,
}

impl Subject {
    /// Loads the scene.
    pub fn load(scene: &Path, reading: &SceneOptions, effort: Effort) -> Result<Self, Failure> {
        let words = [reading.words()?, vec![format!("--size={}", effort.size)]].concat();
        let options = options(&"pt".parse().map_err(Failure::run)?, scene, &words)?;
        let mut found = Vec::new();
        let setup = Setup::edited(&options, |description| found = emitters(description))?;
        let count = found.len().min(MOST_GROUPS);
        let group = |first: usize| {
            let names: Vec<_> = found.iter().skip(first).step_by(count).map(|(_, name)| name.as_str()).collect();
            let keep: Vec<_> = found.iter().skip(first).step_by(count).map(|(emitter, _)| *emitter).collect();
            let lit = Setup::edited(&options, |description| put_out_all_but(&keep, description))?;
            Ok::<_, Failure>((names.join(", "), lit))
        };
        let groups = (0..count).map(group).collect::<Result<_, _>>()?;
        let moved = Setup::edited(&options, nudge_lights)?;
        Ok(Self { scene: scene.to_owned(), effort, setup, groups, moved })
    }

    /// Replicas of a method, and relMSE between two frames with the lights moved.
    pub fn replicas(&self, contestant: &Contestant, interrupt: &Interrupt) -> Result<(Vec<Replica>, f64), Failure> {
        let base = options(contestant, &self.scene, &[])?.method();
        let words = self.effort.options_of(base);
        let render =
            |setup: &Setup, index: u64| self.render(contestant, setup, &words, self.effort.seed + index, interrupt);
        let made: Result<Vec<Replica>, Failure> =
            (0..self.effort.replicas).into_par_iter().map(|index| render(&self.setup, index)).collect();
        let (made, moved) = (made?, render(&self.moved, 0)?);
        let level = mean_of(made.iter().flat_map(|r| r.pixels.iter().copied()));
        let frames = rel_mse(made[0].pixels.iter().copied(), &moved.pixels, level);
        Ok((made, frames))
    }

    /// Replicas of a reference, each the sum of renders by one group of lights alone.
    ///
    /// A light that is one of many, or weak, or tiny is then sampled as often as any other group.
    pub fn reference(&self, contestant: &Contestant, interrupt: &Interrupt) -> Result<Reference, Failure> {
        let base = options(contestant, &self.scene, &[])?.method();
        let per_pixel = (self.effort.per_pixel_of(base) / self.groups.len() as f64).ceil();
        let words = format!("--rounds=1 {}", Plan::budget_option(base, per_pixel, 1));
        let words: Vec<_> = words.split_whitespace().map(str::to_owned).collect();
        let parts: Result<Vec<Vec<Vec<f64>>>, Failure> = (0..self.effort.replicas)
            .into_par_iter()
            .map(|index| {
                let seed = REFERENCE_SEEDS + self.effort.seed + index;
                let part =
                    |(_, setup): &(String, Setup)| Ok(self.render(contestant, setup, &words, seed, interrupt)?.pixels);
                self.groups.iter().map(part).collect()
            })
            .collect();
        Ok(Reference::new(self.groups.iter().map(|group| group.0.clone()), &parts?))
    }

    fn render(
        &self,
        contestant: &Contestant,
        setup: &Setup,
        words: &[String],
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Replica, Failure> {
        let words = [&[format!("--seed={seed}")], words].concat();
        let rendered = render::in_memory(&options(contestant, &self.scene, &words)?, setup, interrupt)?;
        if rendered.report.interrupted {
            return Err(Failure::InterruptedEarly(anyhow::anyhow!("interrupted")));
        }
        Ok(Replica::new(rendered))
    }

    /// Width and height of the images.
    pub fn size(&self) -> [usize; 2] {
        [self.effort.size.width, self.effort.size.height]
    }
}

/// Renders of the reference methods.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Pixels by replica.
    pub replicas: Vec<Vec<f64>>,
    /// Mean images of the groups of lights.
    pub groups: Vec<Group>,
}

impl Reference {
    /// `parts`: pixels by replica and group.
    fn new(names: impl Iterator<Item = String>, parts: &[Vec<Vec<f64>>]) -> Self {
        let sum = |groups: &Vec<Vec<f64>>| {
            let mut total = vec![0.0; groups.first().map_or(0, Vec::len)];
            groups.iter().for_each(|group| total.iter_mut().zip(group).for_each(|(t, x)| *t += x));
            total
        };
        let mean = |group: usize| {
            let pooled = Evidence::pooled(parts.iter().map(|groups| groups[group].as_slice()));
            pooled.into_iter().map(|pixel| pixel.0).collect()
        };
        let groups = names.enumerate().map(|(index, name)| Group { name, pixels: mean(index) }).collect();
        Self { replicas: parts.iter().map(sum).collect(), groups }
    }
}

/// The method that a method is judged by: the first of bidirectional and path tracing that is another.
pub fn reference_for(contestant: &Contestant, scene: &Path, wanted: &Contestant) -> Result<Contestant, Failure> {
    let method = |contestant: &Contestant| Ok::<_, Failure>(options(contestant, scene, &[])?.method());
    if method(contestant)? != method(wanted)? {
        return Ok(wanted.clone());
    }
    let other = if method(wanted)? == Method::Bdpt { "pt" } else { "bdpt" };
    other.parse().map_err(Failure::run)
}

fn options(contestant: &Contestant, scene: &Path, words: &[String]) -> Result<RenderOptions, Failure> {
    contestant.render_options(scene, words).map_err(Failure::run)
}

/// A source of light.
#[derive(Clone, Copy, PartialEq)]
enum Emitter {
    /// The material of this number, where a mesh has it.
    Material(usize),
    /// The light without extent of this number.
    Punctual(usize),
    /// All around.
    Environment,
}

/// All of them, with their names.
fn emitters(description: &SceneDescription) -> Vec<(Emitter, String)> {
    let SceneDescription { meshes, materials, punctual, environment, .. } = description;
    let emits = |index: &usize| {
        materials[*index].emission != Rgb::ZERO && meshes.iter().any(|mesh| mesh.material as usize == *index)
    };
    let surfaces = (0..materials.len()).filter(emits);
    let surfaces = surfaces.map(|index| (Emitter::Material(index), materials[index].name.clone()));
    let points = punctual.iter().enumerate().map(|(index, light)| (Emitter::Punctual(index), light.name.clone()));
    let around = environment.iter().filter(|environment| environment.is_lit());
    let around = around.map(|_| (Emitter::Environment, "the environment".to_owned()));
    surfaces.chain(points).chain(around).collect()
}

fn put_out_all_but(kept: &[Emitter], description: &mut SceneDescription) {
    let SceneDescription { materials, punctual, environment, .. } = description;
    let materials = materials.iter_mut().enumerate().map(|(i, m)| (Emitter::Material(i), &mut m.emission));
    let points = punctual.iter_mut().enumerate().map(|(i, light)| (Emitter::Punctual(i), &mut light.emission));
    materials.chain(points).filter(|(emitter, _)| !kept.contains(emitter)).for_each(|(_, light)| *light = Rgb::ZERO);
    if !kept.contains(&Emitter::Environment) {
        *environment = None;
    }
}

fn nudge_lights(description: &mut SceneDescription) {
    let size = mlt_scene::bounds(description).map_or(0.0, |[low, high]| low.distance(high));
    let aside = DVec3::X * (NUDGE * size);
    let SceneDescription { meshes, materials, punctual, environment, .. } = description;
    for mesh in meshes.iter_mut().filter(|mesh| materials[mesh.material as usize].emission != Rgb::ZERO) {
        mesh.positions.iter_mut().for_each(|p| *p += aside);
    }
    for light in punctual {
        if let Punctual::Point { position } | Punctual::Spot { position, .. } = &mut light.kind {
            *position += aside;
        }
    }
    if let Some(environment) = environment {
        environment.rotation += NUDGE;
    }
}
