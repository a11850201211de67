//! The text that the OBJ parser gets to see, and the line at which it stops.

use crate::{SceneError, guard};
use rayon::prelude::*;
use std::{
    borrow::Cow,
    collections::BTreeSet,
    io::{self, BufRead, Read},
    path::Path,
};

/// An OBJ text without what the renderer has no use for; lines keep their numbers.
#[derive(Default)]
pub(super) struct Reduced {
    /// Positions, normals, faces, objects and materials in use; no `mtllib`.
    pub text: String,
    /// Material libraries in the order of the file.
    pub libraries: Vec<String>,
    /// Names of materials in use.
    pub used: BTreeSet<String>,
    has_lines: bool,
    has_colours: bool,
    has_curves: bool,
}

impl Reduced {
    /// Reduces `text`.
    pub fn new(text: &str) -> Self {
        let add = |mut reduced: Self, line: &str| {
            let kept = reduced.line(line.trim());
            reduced.text.push_str(&kept);
            reduced.text.push('\n');
            reduced
        };
        text.strip_prefix('\u{feff}')
            .unwrap_or(text)
            .par_lines()
            .fold(Self::default, add)
            .reduce(Self::default, Self::then)
    }

    /// This text and another after it.
    fn then(mut self, next: Self) -> Self {
        if self.text.is_empty() {
            return next;
        }
        self.text += &next.text;
        self.libraries.extend(next.libraries);
        self.used.extend(next.used);
        self.has_lines |= next.has_lines;
        self.has_colours |= next.has_colours;
        self.has_curves |= next.has_curves;
        self
    }

    fn line<'a>(&mut self, line: &'a str) -> Cow<'a, str> {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let numbers = line.split('#').next().unwrap_or("");
        match key {
            "v" if numbers.split_whitespace().count() > 6 => {
                self.has_colours = true;
                return numbers.split_whitespace().take(4).collect::<Vec<_>>().join(" ").into();
            }
            "v" | "vn" | "f" => return numbers.into(),
            "o" | "g" => return line.into(),
            "usemtl" => {
                self.used.insert(rest.trim().to_owned());
                return line.into();
            }
            "mtllib" => self.libraries.push(rest.trim().to_owned()),
            "l" | "p" => self.has_lines = true,
            "curv" | "curv2" | "surf" => self.has_curves = true,
            _ => {}
        }
        "".into()
    }

    /// What was left out and would have been seen.
    pub fn warnings(&self) -> Vec<String> {
        let features = [
            (self.has_lines, "points and lines"),
            (self.has_colours, "vertex colours"),
            (self.has_curves, "curves and free-form surfaces"),
        ];
        let sentence = |f: &(bool, &str)| format!("{} are not supported and left out", f.1);
        features.iter().filter(|f| f.0).map(sentence).collect()
    }
}

/// An MTL text in which every colour has three components: a single one stands for all (MTL's own rule).
pub(super) fn library(text: &str) -> String {
    let line = |line: &str| {
        let words: Vec<_> = line.split('#').next().unwrap_or("").split_whitespace().collect();
        match words[..] {
            [key @ ("Ka" | "Kd" | "Ks" | "Ke" | "Tf"), grey] => format!("{key} {grey} {grey} {grey}\n"),
            ["Ka" | "Kd" | "Ks" | "Ke" | "Tf", ..] => words.join(" ") + "\n",
            _ => line.to_owned() + "\n",
        }
    };
    text.strip_prefix('\u{feff}').unwrap_or(text).lines().map(line).collect()
}

/// Runs a parser; its error, or its panic, names the line that it read last.
pub(super) fn parse<T>(
    path: &Path,
    format: &'static str,
    text: &str,
    parser: impl FnOnce(&mut Numbered) -> Result<T, String>,
) -> Result<T, SceneError> {
    let mut numbered = Numbered { rest: text.as_bytes(), line: 0 };
    let result = guard::catch(|| parser(&mut numbered));
    result.unwrap_or_else(|_| Err("malformed numbers".to_owned())).map_err(|reason| {
        let reason = format!("{reason} at line {} or before", numbered.line);
        SceneError::Syntax { path: path.to_owned(), format, reason }
    })
}

/// A text that counts the lines read.
pub(super) struct Numbered<'a> {
    rest: &'a [u8],
    line: usize,
}

impl Read for Numbered<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Numbered<'_> {
    /// At most one line.
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let end = self.rest.iter().position(|&b| b == b'\n').map_or(self.rest.len(), |at| at + 1);
        Ok(&self.rest[..end])
    }

    fn consume(&mut self, count: usize) {
        let (read, rest) = self.rest.split_at(count);
        self.line += usize::from(read.ends_with(b"\n"));
        self.rest = rest;
    }
}
