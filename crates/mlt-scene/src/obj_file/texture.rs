//! MTL's texture statements: options, and the file that they name.

use crate::{SceneError, images::Sampler, source::Source};
use glam::{Affine2, Vec2};
use mlt_core::transport::scene::Wrap;

/// Statements that name a texture which is read, in lower case: MTL's own, and those of its extension for physically based
/// materials.
pub(super) const READ: [&str; 10] =
    ["map_kd", "map_ks", "map_ns", "map_d", "map_ke", "map_pr", "map_pm", "map_bump", "bump", "norm"];

/// Prefix of the keywords under which the parser keeps texture statements whole.
pub(super) const PREFIX: &str = "texture:";

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statement {
    /// The file as it is named.
    pub file: String,
    /// Scale and offset of texture coordinates, v downwards.
    pub transform: Affine2,
    pub sampler: Sampler,
    /// `-bm`: how strong a bump map is.
    pub bump: f32,
    /// `-imfchan`: the channel of a single number.
    pub channel: Option<u8>,
}

impl Statement {
    /// Reads what follows a keyword; `None`: it names no file.
    pub(super) fn parse(rest: &str) -> Option<Self> {
        let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
        let mut statement = Self {
            file: String::new(),
            transform: Affine2::IDENTITY,
            sampler: Sampler::default(),
            bump: 1.0,
            channel: None,
        };
        let mut rest = rest.trim();
        while let Some((option, values)) = option(rest) {
            let number = |i: usize| values.get(i)?.parse::<f32>().ok().filter(|x| x.is_finite());
            match option {
                "-s" => scale = Vec2::new(number(0).unwrap_or(1.0), number(1).unwrap_or(1.0)),
                "-o" => offset = Vec2::new(number(0).unwrap_or(0.0), number(1).unwrap_or(0.0)),
                "-bm" => statement.bump = number(0).unwrap_or(1.0),
                "-clamp" if values.first() == Some(&"on") => statement.sampler.wrap = [Wrap::Clamp; 2],
                "-imfchan" => statement.channel = values.first().and_then(|name| channel(name)),
                _ => {}
            }
            rest = behind(rest, 1 + values.len());
        }
        // From v upwards to v upwards, seen with v downwards.
        let offset = Vec2::new(offset.x, 1.0 - scale.y - offset.y);
        statement.transform = Affine2::from_scale_angle_translation(scale, 0.0, offset);
        statement.file = super::text::unquoted(rest).to_owned();
        (!statement.file.is_empty()).then_some(statement)
    }

    /// The content of its file: beside the library, beside the scene, or there by its name alone, as of a path of another
    /// machine.
    pub(super) fn content(&self, source: &Source, folder: &str) -> Result<Vec<u8>, SceneError> {
        let path = self.file.replace('\\', "/");
        let name = path.rsplit('/').next().unwrap_or(&path);
        let beside_library = |file: &str| format!("{folder}{file}");
        let first = source.read_beside(&beside_library(&path));
        let others = [path.clone(), beside_library(name), name.to_owned()];
        first.or_else(|error| others.iter().find_map(|file| source.read_beside(file).ok()).ok_or(error))
    }
}

fn channel(name: &str) -> Option<u8> {
    Some(match name {
        "r" | "l" => 0,
        "g" => 1,
        "b" => 2,
        "m" => 3,
        _ => return None,
    })
}

/// The option that a statement goes on with, and its values.
fn option(rest: &str) -> Option<(&str, Vec<&str>)> {
    let mut words = rest.split_whitespace();
    let option = words.next()?;
    let most = match option {
        "-s" | "-o" | "-t" => 3,
        "-mm" => 2,
        "-blendu" | "-blendv" | "-boost" | "-texres" | "-clamp" | "-bm" | "-imfchan" | "-type" | "-cc"
        | "-colorspace" => 1,
        _ => return None,
    };
    let is_number = |word: &&str| word.parse::<f32>().is_ok();
    let values = match option {
        "-s" | "-o" | "-t" | "-mm" | "-boost" | "-texres" | "-bm" => words.take_while(is_number).take(most).collect(),
        _ => words.take(most).collect(),
    };
    Some((option, values))
}

/// The text behind so many words.
fn behind(text: &str, words: usize) -> &str {
    (0..words)
        .fold(text.trim_start(), |rest, _| rest.find(char::is_whitespace).map_or("", |end| rest[end..].trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_a_name_that_may_have_blanks() {
        let s = Statement::parse("-s 2 3 1 -o 0.5 -clamp on -bm 0.25 -imfchan g -mm 0 1 my wood (1).png").unwrap();
        assert_eq!((s.file.as_str(), s.bump, s.channel), ("my wood (1).png", 0.25, Some(1)));
        assert_eq!(s.sampler.wrap, [Wrap::Clamp; 2]);
        // v upwards 0 is 1 downwards: 3·0 upwards is 0, which is 1 downwards.
        assert_eq!(s.transform.transform_point2(Vec2::new(0.0, 1.0)), Vec2::new(0.5, 1.0));
        assert_eq!(s.transform.transform_point2(Vec2::new(1.0, 0.0)), Vec2::new(2.5, -2.0));
    }

    #[test]
    fn a_name_alone_is_taken_as_it_is() {
        for (rest, file) in [
            ("wood.png", "wood.png"),
            ("  C:\\my textures\\wood.png ", "C:\\my textures\\wood.png"),
            ("\"a b.png\"", "a b.png"),
            ("-s 1 1 7.png", "7.png"),
            ("-unknown x.png", "-unknown x.png"),
        ] {
            let statement = Statement::parse(rest).unwrap();
            assert_eq!(statement.file, file);
            assert_eq!(statement.transform.transform_point2(Vec2::splat(0.25)), Vec2::splat(0.25));
        }
        assert_eq!(Statement::parse("-s 1 1 1"), None);
        assert_eq!(Statement::parse(" "), None);
    }
}
