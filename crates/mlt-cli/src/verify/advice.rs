//! Advice that follows from a verdict for whoever renders the scene.

use super::verdict::{Status, Verdict};
use crate::args::written::shell_word;

impl Verdict {
    /// One or two sentences that begin with what to do.
    pub fn advice(&self) -> String {
        let Self { method, reference, replicas, .. } = self;
        let scene = shell_word(&self.scene);
        let has = |words: &[&str]| self.faults.iter().any(|fault| words.contains(&fault.word.as_str()));
        match self.status {
            Status::Passes => format!("render it by {}; its error bars can be believed", command(&scene, method)),
            Status::Inconclusive if self.bias.is_none() => {
                format!("look where the camera stands and which lights count: mlt inspect {scene}")
            }
            Status::Inconclusive => format!(
                "judge again with more renders, which halves what goes unseen: mlt verify {scene} --replicas {}; until then \
                 compare {} with --method {reference}",
                (4 * replicas).min(10_000),
                command(&scene, method)
            ),
            Status::Fails if has(&["wrong"]) => format!(
                "do not use {method} for this scene: {}; if that cannot be trusted either, the scene is beyond both",
                command(&scene, reference)
            ),
            Status::Fails => format!(
                "render several times longer than usual, or by {}, and take error bars of {method} for lower bounds here",
                command(&scene, reference)
            ),
        }
    }
}

/// The command that renders by a method as it is named for a study.
fn command(scene: &str, method: &str) -> String {
    let mut parts = method.split(':');
    let options: String = match parts.next() {
        Some("auto") | None => String::new(),
        Some(name) => format!(" --method {name}"),
    };
    let more: String = parts
        .map(|part| match part.split_once('=') {
            Some((name, value)) => format!(" --{name} {}", shell_word(value)),
            None => format!(" --strata {part}"),
        })
        .collect();
    format!("mlt render {scene}{options}{more}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_become_commands() {
        for (method, line) in [
            ("auto", "mlt render a.glb"),
            ("pt", "mlt render a.glb --method pt"),
            ("mlt:4x4:importance=relative", "mlt render a.glb --method mlt --strata 4x4 --importance relative"),
        ] {
            assert_eq!(command("a.glb", method), line);
        }
    }
}
