//! The study of all methods on all scenes of the gallery, and its table.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context;
use clap::ValueEnum;
use mlt_scene::EnvironmentSource;
use mlt_scene::gallery::{HardScene, RightOutcome, SCENES, find};
use serde::{Deserialize, Serialize};

use super::{
    Court,
    errors::Errors,
    verdict::{Status, Verdict},
};
use crate::{
    Failure,
    args::{contestant::Contestant, environment::Source, transport::Method, verify::VerifyOptions},
    atomic,
};

/// The verdict on a scene and method, with what decides it.
#[derive(Deserialize, Serialize)]
struct Kept {
    identity: String,
    verdict: Verdict,
}

/// The scenes asked for, or all.
pub(super) fn scenes(options: &VerifyOptions) -> Result<Vec<&'static HardScene>, Failure> {
    if options.scenes.is_empty() {
        return Ok(SCENES.iter().collect());
    }
    let scene = |name: &PathBuf| {
        find(&name.to_string_lossy()).ok_or_else(|| {
            let names: Vec<_> = SCENES.iter().map(|scene| scene.name).collect();
            Failure::Usage(anyhow::anyhow!("the gallery has no scene {}; it has {}", name.display(), names.join(", ")))
        })
    };
    options.scenes.iter().map(scene).collect()
}

/// Strata that a pilot finds are another way to work, with failures of its own.
const STRATIFIED: &str = "mlt:auto:weights=adaptive";

/// The words of faults, and their meaning.
const FAULTS: [(&str, &str); 6] = [
    ("wrong", "another image than the reference's"),
    ("unsteady", "the worst seed's relMSE is more than 3 times the median's"),
    ("bars", "95 % error bars hold the truth in less than 90 % of pixels"),
    ("rounds", "rounds of a render are not independent"),
    ("b", "the normalisations b are less certain than they say"),
    ("seeds", "replicas with different seeds are the same image"),
];

/// Every method there is.
pub(super) fn all_methods() -> Result<Vec<Contestant>, Failure> {
    let names = Method::value_variants().iter().map(Method::to_string).chain([STRATIFIED.to_owned()]);
    let methods = names.map(|name| name.parse()).collect::<Result<_, String>>();
    methods.map_err(|message| Failure::Run(anyhow::anyhow!(message)))
}

/// Judges what is not judged yet, and writes both pages after each scene.
pub(super) fn run(
    court: &Court,
    options: &VerifyOptions,
    scenes: &[&HardScene],
    folder: &Path,
) -> Result<Vec<Verdict>, Failure> {
    let command = options.command_of_gallery()?;
    let create =
        |path: &Path| fs::create_dir_all(path).with_context(|| format!("{}: cannot be created", path.display()));
    create(&folder.join("verdicts"))?;
    let mut verdicts = Vec::new();
    for scene in scenes {
        let files = folder.join("scenes").join(scene.name);
        create(&files)?;
        let path = scene.write(&files).with_context(|| format!("{}: cannot be written", files.display()))?;
        verdicts.extend(of_scene(court, scene, &path, folder)?);
        let pages =
            [("stability.md", page(&verdicts, scenes, court, &command)), ("stability-figures.md", figures(&verdicts))];
        for (name, text) in pages {
            atomic::write(&folder.join(name), text.as_bytes())?;
        }
    }
    Ok(verdicts)
}

fn of_scene(court: &Court, scene: &HardScene, path: &Path, folder: &Path) -> Result<Vec<Verdict>, Failure> {
    let file = |method: &Contestant| {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.=".contains(c) { c } else { '_' };
        let name: String = format!("{}-{method}", scene.name).chars().map(plain).collect();
        folder.join("verdicts").join(name + ".json")
    };
    let content = fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
    let identity = |method: &Contestant| format!("{} {method} {:016x}", court.identity, fingerprint(&content));
    let kept = |method: &Contestant| -> Option<Verdict> {
        let kept: Kept = serde_json::from_slice(&fs::read(file(method)).ok()?).ok()?;
        (kept.identity == identity(method)).then_some(kept.verdict)
    };
    let mut keep = |method: &Contestant, verdict: &mut Verdict| -> Result<(), Failure> {
        scene.name.clone_into(&mut verdict.scene);
        if scene.outcome == RightOutcome::Black && verdict.bias.is_none() {
            (verdict.status, verdict.remarks) = (Status::Passes, vec!["black, as it has to be".into()]);
        }
        let kept = Kept { identity: identity(method), verdict: verdict.clone() };
        let json = serde_json::to_string_pretty(&kept).context("cannot encode a verdict")?;
        Ok(atomic::write(&file(method), json.as_bytes())?)
    };
    // A scene that is to be refused would get a sky.
    let mut reading = court.reading.clone();
    if scene.outcome == RightOutcome::Refused {
        reading.environment.environment = Some(Source(EnvironmentSource::None));
    }
    match court.judge(path, &reading, &kept, &mut keep) {
        Err(Failure::Run(error)) if scene.outcome == RightOutcome::Refused => Ok(refused(court, scene, &error)),
        other => other,
    }
}

/// A scene that no method renders, and should not.
fn refused(court: &Court, scene: &HardScene, error: &anyhow::Error) -> Vec<Verdict> {
    let sentence = format!("{error:#}");
    let told = sentence.contains("no light") && !sentence.contains('\n');
    let verdict = |method: &Contestant| Verdict {
        scene: scene.name.to_owned(),
        method: method.to_string(),
        reference: String::new(),
        replicas: 0,
        status: if told { Status::Passes } else { Status::Fails },
        faults: Vec::new(),
        remarks: vec!["refused, as it has to be".into()],
        bias: None,
        chains: None,
        errors: None,
        warnings: BTreeMap::new(),
    };
    court.methods.iter().map(verdict).collect()
}

/// FNV-1a, 64 bits.
fn fingerprint(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The page docs/stability.md.
fn page(verdicts: &[Verdict], scenes: &[&HardScene], court: &Court, command: &str) -> String {
    let mut page = format!(
        "# Where methods fail\n\n{}\nWritten by\n\n    {command}\n\n[verify.md](verify.md) says what it tests, \
         [gallery.md](gallery.md) shows the scenes,\nand [stability-figures.md](stability-figures.md) has the figures behind the words.\n\
         For each scene and method: {}.\n\n",
        in_short(verdicts),
        court.identity
    );
    let methods: Vec<String> = court.methods.iter().map(Contestant::to_string).collect();
    page += "## Verdicts\n\n";
    page += &format!("| scene | what is hard | {} |\n|---|---|{}\n", methods.join(" | "), "---|".repeat(methods.len()));
    for scene in scenes {
        let of = |method: &String| verdicts.iter().find(|v| v.scene == scene.name && v.method == *method);
        let cells: Vec<String> = methods.iter().map(|method| of(method).map_or_else(|| "…".into(), cell)).collect();
        page += &format!("| {} | {} | {} |\n", scene.name, scene.stresses, cells.join(" | "));
    }
    page += "\n## Failures\n\n";
    for verdict in verdicts.iter().filter(|v| v.status == Status::Fails) {
        page += &format!("- {} × {}: {}.\n", verdict.scene, verdict.method, verdict.reasons());
    }
    page
}

/// Numbers of verdicts and of faults, and the meaning of the words.
fn in_short(verdicts: &[Verdict]) -> String {
    let of = |status| verdicts.iter().filter(|verdict| verdict.status == status).count();
    let faulty = |word| verdicts.iter().filter(|verdict| verdict.faults.iter().any(|fault| fault.word == word)).count();
    let meanings = FAULTS.map(|(word, meaning)| format!("  - *{word}*, {} of them: {meaning}.\n", faulty(word)));
    format!(
        "Each method renders each scene many times, and is compared with another method. Of {} verdicts:\n\n\
         - **passes**, {}: no fault was found, and an error of 1 % of the image, or 10 % of a region, would have been.\n\
         - **inconclusive**, {}: no fault was found, but errors up to the figures (image, region) would not have been seen.\n\
         - **fails**, {}, by one or more of these faults:\n{}",
        verdicts.len(),
        of(Status::Passes),
        of(Status::Inconclusive),
        of(Status::Fails),
        meanings.concat()
    )
}

fn cell(verdict: &Verdict) -> String {
    match (&verdict.bias, verdict.status) {
        (Some(bias), Status::Inconclusive) => {
            format!("inconclusive ({:.1} %, {:.0} %)", 100.0 * bias.visible, 100.0 * bias.visible_in_regions)
        }
        (_, Status::Fails) => {
            let words: Vec<&str> = verdict.faults.iter().map(|fault| fault.word.as_str()).collect();
            format!("**fails**: {}", words.join(", "))
        }
        (_, status) => status.word().into(),
    }
}

fn bars(Errors { coverage, doubted, .. }: &Errors) -> String {
    let coverage = coverage.map_or_else(|| "–".into(), |coverage| format!("{:.1} %", 100.0 * coverage));
    if *doubted > 0 { format!("{coverage} ({doubted})") } else { coverage }
}

/// The page docs/stability-figures.md: the figures behind the words.
fn figures(verdicts: &[Verdict]) -> String {
    let mut text = "# Figures behind the verdicts\n\n[stability.md](stability.md) has the verdicts in words, and the command that writes both pages.\n\np: of so large a difference from the reference, corrected. Visible: error of the image, and of \
                    a region, seen in 4 of 5 studies. Bars: share of 95 %\nerror bars that hold the truth, and in brackets the seeds that say themselves that theirs cannot be trusted, which are \
                    left out. relMSE: median over seeds, and the worst over it. R̂: \
                    of rounds in the worst block.\nStuck: longest run of rejections. Flicker: lights moved by a millionth, over \
                    another seed.\n\n\
                    | scene | method | by | p | image | visible | bars | relMSE | worst | R̂ | stuck | flicker |\n\
                    |---|---|---|---|---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for verdict in verdicts {
        let (Some(bias), Some(chains), Some(errors)) = (&verdict.bias, &verdict.chains, &verdict.errors) else {
            continue;
        };
        let optional = |value: Option<String>| value.unwrap_or_else(|| "–".into());
        text += &format!(
            "| {} | {} | {} | {:.1e} | {:+.2} ± {:.2} % | {:.2} %, {:.1} % | {} | {:.1e} | {:.1} | {} | {} | {} |\n",
            verdict.scene,
            verdict.method,
            verdict.reference,
            bias.p,
            100.0 * bias.image_difference,
            100.0 * bias.image_stderr,
            100.0 * bias.visible,
            100.0 * bias.visible_in_regions,
            bars(errors),
            errors.median,
            errors.worst,
            optional(chains.r_hat.map(|r_hat| format!("{r_hat:.3}"))),
            if chains.b_spread.is_some() { chains.longest_rejection.to_string() } else { "–".into() },
            optional(errors.moved.map(|ratio| format!("{ratio:.0e}"))),
        );
    }
    text
}
