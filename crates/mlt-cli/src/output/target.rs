//! Files to write: their names, and whether they can be written.

use std::{
    fs::{self, OpenOptions},
    io::{self, Cursor, ErrorKind, IsTerminal, Read, Seek, Write},
    path::{Path, PathBuf},
    str::FromStr,
};

use anyhow::{Context, bail};

use super::Format;
use crate::atomic;

/// The name that stands for standard output.
const STDOUT: &str = "-";

/// Takes the bytes of a file.
pub trait Medium: Read + Write + Seek {}

impl<T: Read + Write + Seek> Medium for T {}

/// A file to write, named by the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Where it goes.
    pub path: PathBuf,
    /// By its extension.
    pub format: Format,
}

impl OutputFile {
    /// Whether it is to hold sums; else an image.
    pub fn holds_sums(&self) -> bool {
        self.format == Format::Sums
    }

    /// Whether it goes to standard output.
    pub fn is_stdout(&self) -> bool {
        self.path == Path::new(STDOUT)
    }

    /// Whether the name has a place for a number: one or more #.
    pub fn is_numbered(&self) -> bool {
        self.path.file_name().is_some_and(|name| name.to_string_lossy().contains('#'))
    }

    /// The file of this number: its last #### are the number, with as many digits or more.
    pub fn numbered(&self, number: u32) -> Self {
        let Some(name) = self.path.file_name().map(|name| name.to_string_lossy()) else { return self.clone() };
        let Some(last) = name.rfind('#') else { return self.clone() };
        let first = name[..last].trim_end_matches('#').len();
        let digits = format!("{number:0width$}", width = last + 1 - first);
        let name = format!("{}{digits}{}", &name[..first], &name[last + 1..]);
        Self { path: self.path.with_file_name(name), format: self.format }
    }

    /// The file for the same image denoised, beside it; `None` for what has no such file.
    pub fn denoised(&self) -> Option<Self> {
        let beside = |path: &Path| {
            let mut name = path.file_stem()?.to_os_string();
            name.push(".denoised.");
            name.push(path.extension()?);
            Some(path.with_file_name(name))
        };
        let path = if self.holds_sums() || self.is_stdout() { None } else { beside(&self.path) };
        path.map(|path| Self { path, format: self.format })
    }

    /// Puts what `content` writes there, whole or not at all if it is a file.
    pub fn write(&self, content: impl FnOnce(&mut dyn Medium) -> anyhow::Result<()>) -> anyhow::Result<()> {
        if !self.is_stdout() {
            return atomic::write_with(&self.path, |file| content(file));
        }
        let (mut bytes, mut stdout) = (Cursor::new(Vec::new()), io::stdout().lock());
        content(&mut bytes)?;
        stdout.write_all(bytes.get_ref()).and_then(|()| stdout.flush()).context("cannot write to standard output")
    }
}

impl FromStr for OutputFile {
    type Err = String;

    /// A file name with an extension, `-`, which is standard output and takes OpenEXR, or `png:-` for another format.
    fn from_str(text: &str) -> Result<Self, String> {
        let named = text.strip_suffix(":-").and_then(Format::of_extension);
        if let Some(format) = named.or((text == STDOUT).then_some(Format::Exr)) {
            return Ok(Self { path: STDOUT.into(), format });
        }
        let path = PathBuf::from(text);
        let format = path.extension().and_then(|extension| Format::of_extension(&extension.to_string_lossy()));
        match format {
            Some(format) => Ok(Self { path, format }),
            None => Err("the name has to end in .exr, .hdr, .png or .jpg, or in .mltp for 'mlt merge'; - is standard \
                         output, as OpenEXR or as in png:-"
                .into()),
        }
    }
}

/// Finds out before a long run whether a file could be written at `path`; leaves nothing behind.
pub fn check_target(path: &Path) -> anyhow::Result<()> {
    let name = path.display();
    let path = &atomic::followed(path).with_context(|| name.to_string())?;
    let folder = atomic::folder_of(path);
    if !folder.is_dir() {
        bail!("{name}: the folder {} does not exist", folder.display());
    }
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() => bail!("{name}: exists and is not a regular file"),
        Ok(_) => {
            OpenOptions::new().write(true).open(path).with_context(|| format!("{name}: cannot be overwritten"))?;
        }
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error).with_context(|| name.to_string()),
        Err(_) => {}
    }
    let temporary = tempfile::tempfile_in(&folder);
    temporary.map(drop).with_context(|| format!("{name}: cannot write in the folder {}", folder.display()))
}

/// Finds out before a long run whether the targets can be written, each to a file of its own; `json`: whether the report goes to standard
/// output.
pub fn check_targets(targets: &[OutputFile], json: bool) -> anyhow::Result<()> {
    let (streams, files): (Vec<_>, Vec<_>) = targets.iter().cloned().partition(OutputFile::is_stdout);
    match &streams[..] {
        [_, _, ..] => bail!("standard output is given twice; give each output a file of its own"),
        [_] if json => bail!("-o - and --json: both go to standard output; give the image a file"),
        [_] if io::stdout().is_terminal() => {
            bail!("-o -: standard output is a terminal, which cannot show an image; add > FILE or | PROGRAM")
        }
        _ => {}
    }
    files.iter().try_for_each(|target| check_target(&target.path))?;
    check_apart(&files)
}

/// Finds out whether two of the targets are one file, by whatever names.
fn check_apart(targets: &[OutputFile]) -> anyhow::Result<()> {
    for (index, OutputFile { path, .. }) in targets.iter().enumerate() {
        for OutputFile { path: earlier, .. } in &targets[..index] {
            if path == earlier {
                bail!("{} is given twice", path.display());
            }
            if is_same_file(path, earlier).with_context(|| path.display().to_string())? {
                bail!(
                    "{} and {} are the same file; give each output a file of its own",
                    earlier.display(),
                    path.display()
                );
            }
        }
    }
    Ok(())
}

/// Whether two names lead to the same file, which need not exist yet.
fn is_same_file(a: &Path, b: &Path) -> io::Result<bool> {
    let [a, b] = [atomic::followed(a)?, atomic::followed(b)?];
    if a.exists() && b.exists() {
        return same_file::is_same_file(a, b);
    }
    Ok(a.file_name() == b.file_name() && same_file::is_same_file(atomic::folder_of(&a), atomic::folder_of(&b))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_names_the_format() {
        let format = |text: &str| text.parse::<OutputFile>().map(|file| file.format);
        assert_eq!(format("a.exr"), Ok(Format::Exr));
        assert_eq!(format("some.folder/A.PNG"), Ok(Format::Png));
        assert_eq!(
            [format("a.jpg"), format("a.JPEG"), format("a.hdr")],
            [Ok(Format::Jpg), Ok(Format::Jpg), Ok(Format::Hdr)]
        );
        assert_eq!(
            [format("-"), format("png:-"), format("./-.exr")],
            [Ok(Format::Exr), Ok(Format::Png), Ok(Format::Exr)]
        );
        for bad in ["a", "a.gif", "exr", ".png", "", "a.exr.gz", "gif:-", ":-", "a.png:-"] {
            assert!(format(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_number_replaces_its_marks() {
        let name = |text: &str, number| {
            let file = text.parse::<OutputFile>().expect("a target").numbered(number);
            file.path.display().to_string()
        };
        assert_eq!(name("a/frame.####.exr", 7), "a/frame.0007.exr");
        assert_eq!([name("#.png", 123), name("ä##b##.png", 5)], ["123.png", "ä##b05.png"]);
        assert_eq!(name("a#/b.png", 5), "a#/b.png");
    }

    #[test]
    fn standard_output_takes_one_thing() {
        let refused = |names: &[&str], json| {
            let targets: Vec<_> = names.iter().map(|name| name.parse().expect("a target")).collect();
            format!("{:#}", check_targets(&targets, json).expect_err("refused"))
        };
        assert!(refused(&["-", "png:-"], false).contains("given twice"));
        assert!(refused(&["jpg:-"], true).contains("both go to standard output"));
    }

    #[test]
    fn a_target_is_checked_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("a.exr");
        assert!(check_target(&target).is_ok());
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);

        fs::write(&target, "old").expect("written");
        assert!(check_target(&target).is_ok());
        assert_eq!(fs::read(&target).expect("kept"), b"old");
    }

    #[cfg(unix)]
    #[test]
    fn two_names_of_one_file_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| OutputFile { path: folder.path().join(name), format: Format::Exr };
        let refused = |a: &str, b: &str| check_apart(&[file(a), file(b)]).err().map(|error| error.to_string());
        fs::create_dir(folder.path().join("sub")).expect("made");
        assert_eq!(refused("a.exr", "b.exr"), None);
        assert!(refused("a.exr", "a.exr").is_some_and(|message| message.ends_with("a.exr is given twice")));
        assert!(refused("a.exr", "sub/../a.exr").is_some_and(|message| message.contains("are the same file")));

        std::os::unix::fs::symlink("a.exr", folder.path().join("link.exr")).expect("linked");
        assert!(refused("a.exr", "link.exr").is_some());
        fs::write(folder.path().join("a.exr"), "").expect("written");
        assert!(refused("a.exr", "link.exr").is_some());
        fs::hard_link(folder.path().join("a.exr"), folder.path().join("hard.exr")).expect("linked");
        assert!(refused("a.exr", "hard.exr").is_some());
        assert_eq!(refused("a.exr", "b.exr"), None);
    }

    #[test]
    fn a_target_that_cannot_be_written_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |path: PathBuf| format!("{:#}", check_target(&path).expect_err("refused"));
        assert!(message(folder.path().join("none/a.exr")).ends_with("none does not exist"));
        assert!(message(folder.path().to_path_buf()).ends_with("is not a regular file"));
        assert!(message(folder.path().join("a".repeat(300) + ".exr")).contains("too long"));
        fs::write(folder.path().join("file"), "").expect("written");
        assert!(message(folder.path().join("file/a.exr")).ends_with("file does not exist"));
    }
}
