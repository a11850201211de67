//! The text that the parsers get to see, and the line at which they stop.

use crate::{SceneError, guard};
use rayon::prelude::*;
use std::{
    borrow::Cow,
    collections::BTreeSet,
    io::{self, BufRead, Read},
    path::Path,
};

/// The name of what has none.
const UNNAMED: &str = "unnamed";

/// A file's text. Its lines end in a line feed alone; what `\` continues is one line, and empty lines behind it keep the count.
pub(super) fn decode(bytes: Vec<u8>) -> String {
    let mut text = characters(bytes);
    if text.starts_with('\u{feff}') {
        text.remove(0);
    }
    if text.contains('\r') {
        text = text.replace("\r\n", "\n").replace('\r', "\n");
    }
    if text.contains('\\') { joined(&text) } else { text }
}

/// UTF-16 where a byte order mark says so, UTF-8, or else Latin-1.
fn characters(bytes: Vec<u8>) -> String {
    let utf16 = |unit: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks().0.iter().copied().map(unit);
        char::decode_utf16(units).map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    match bytes.first_chunk() {
        Some([0xff, 0xfe]) => utf16(u16::from_le_bytes),
        Some([0xfe, 0xff]) => utf16(u16::from_be_bytes),
        _ => String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect()),
    }
}

/// The text with each line that ends in `\` joined to the next; a comment does not go on.
fn joined(text: &str) -> String {
    let (mut joined, mut continued) = (String::with_capacity(text.len() + 1), 0);
    for line in text.lines() {
        match line.trim_end().strip_suffix('\\') {
            Some(start) if !start.contains('#') => {
                joined.push_str(start);
                joined.push(' ');
                continued += 1;
            }
            _ => {
                joined.push_str(line);
                (0..=continued).for_each(|_| joined.push('\n'));
                continued = 0;
            }
        }
    }
    joined
}

/// Rest of a statement behind its keyword, without quotes.
pub(super) fn unquoted(rest: &str) -> &str {
    let rest = rest.trim();
    let quoted = rest.strip_prefix('"').and_then(|rest| rest.split_once('"'));
    quoted.map_or(rest, |(name, _)| name.trim())
}

/// Rest of a statement behind its keyword, as a name with single blanks; [`UNNAMED`] if it says nothing.
pub(super) fn name(rest: &str) -> String {
    match unquoted(rest) {
        "" => UNNAMED.to_owned(),
        name => name.split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

/// A name without what follows a `#`; that can be a comment or part of the name.
pub(super) fn without_comment(name: &str) -> &str {
    let starts = |at: usize| name[..at].trim_end().len() < at || at == 0;
    match name.match_indices('#').find(|&(at, _)| starts(at)).map(|(at, _)| name[..at].trim_end()) {
        Some("") => UNNAMED,
        Some(name) => name,
        None => name,
    }
}

/// A statement of numbers without the comment behind it; `1.#` begins what some programs write for no number.
pub(super) fn without_remark(line: &str) -> &str {
    let remark = line.match_indices('#').find(|&(at, _)| !line[..at].ends_with("1."));
    remark.map_or(line, |(at, _)| &line[..at])
}

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
    /// Some vertices have colours.
    has_colours: bool,
    /// Some vertices have none.
    has_plain: bool,
    has_curves: bool,
}

/// Attributes that vertices keep besides positions and normals.
#[derive(Clone, Copy)]
struct Kept {
    colours: bool,
    coordinates: bool,
}

impl Reduced {
    /// Reduces `text`. Colours are kept where every vertex has one.
    pub(super) fn new(text: &str) -> Self {
        let all = Kept { colours: true, coordinates: true };
        let reduced = Self::keeping(text, all);
        let mixed = reduced.has_colours && reduced.has_plain;
        if mixed { Self::keeping(text, Kept { colours: false, ..all }) } else { reduced }
    }

    /// The same without texture coordinates, where faces name some that are not there.
    pub(super) fn without_coordinates(&self, text: &str) -> Self {
        Self::keeping(text, Kept { colours: !self.has_plain, coordinates: false })
    }

    fn keeping(text: &str, kept: Kept) -> Self {
        let add = |mut reduced: Self, line: &str| {
            let line = reduced.line(line.trim(), kept);
            reduced.text.push_str(&line);
            reduced.text.push('\n');
            reduced
        };
        text.par_lines().fold(Self::default, add).reduce(Self::default, Self::then)
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
        self.has_plain |= next.has_plain;
        self.has_curves |= next.has_curves;
        self
    }

    fn line<'a>(&mut self, line: &'a str, kept: Kept) -> Cow<'a, str> {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match key {
            "v" => return self.position(without_remark(line), kept.colours),
            "vn" => return numbers(without_remark(line), 3),
            "vt" if kept.coordinates => return texture_coordinates(without_remark(line)),
            "f" => return without_remark(line).into(),
            "fo" => return format!("f {}", without_remark(rest)).into(),
            "o" | "g" => return line.into(),
            "usemtl" => {
                let name = name(rest);
                let line = format!("usemtl {name}");
                self.used.insert(name);
                return line.into();
            }
            "mtllib" => self.libraries.push(rest.trim().to_owned()),
            "l" | "p" => self.has_lines = true,
            "curv" | "curv2" | "surf" => self.has_curves = true,
            _ if key.contains(|c: char| c.is_ascii_uppercase()) => {
                let lower = format!("{} {rest}", key.to_ascii_lowercase());
                return self.line(lower.trim_end(), kept).into_owned().into();
            }
            _ => {}
        }
        "".into()
    }

    /// A vertex, with its colour if `colours` are wanted and it has one, as numbers that the parser knows.
    fn position<'a>(&mut self, line: &'a str, colours: bool) -> Cow<'a, str> {
        let coloured = line.split_whitespace().count() > 6;
        self.has_colours |= coloured;
        self.has_plain |= !coloured;
        // Without a colour there may be a weight.
        let most = match (coloured, colours) {
            (true, true) => 6,
            (true, false) => 3,
            (false, _) => 4,
        };
        numbers(line, most)
    }

    /// Parts of the file that were left out and would have been seen.
    pub(super) fn warnings(&self) -> Vec<String> {
        let features = [
            (self.has_lines, "points and lines are not supported and left out"),
            (
                self.has_colours && self.has_plain,
                "some vertices have colours and some have none; all colours are left out",
            ),
            (self.has_curves, "curves and free-form surfaces are not supported and left out"),
        ];
        features.iter().filter(|f| f.0).map(|f| f.1.to_owned()).collect()
    }
}

/// A statement of at most so many numbers, as the parser knows them.
fn numbers(line: &str, most: usize) -> Cow<'_, str> {
    // `-nan(ind)`, `1.#QNAN`
    let odd = line.contains(['(', '#']);
    if !odd && line.split_whitespace().count() <= most + 1 {
        return line.into();
    }
    let plain = |word| if odd && str::contains(word, ['(', '#']) { "nan" } else { word };
    line.split_whitespace().take(most + 1).map(plain).collect::<Vec<_>>().join(" ").into()
}

/// Two numbers: what is missing or no number is 0.
fn texture_coordinates(line: &str) -> Cow<'_, str> {
    let mut words = line.split_whitespace().skip(1).map(str::parse::<f32>);
    let mut next = || words.next().and_then(Result::ok).unwrap_or(0.0);
    let (u, v) = (next(), next());
    format!("vt {u} {v}").into()
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
