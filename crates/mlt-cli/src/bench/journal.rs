//! The results so far, on disk.

use std::{
    fs::{self, File, OpenOptions},
    io::{ErrorKind, Write},
    path::{Path, PathBuf},
};

use anyhow::Context;

use super::row::{Key, Row};

/// A file of JSON lines, one a run, that is only ever added to.
///
/// A line that cannot be read, such as one cut short when the program was killed, is as good as a run that was not made.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    rows: Vec<Row>,
}

impl Journal {
    /// Opens or creates the file.
    pub(super) fn open(path: &Path) -> anyhow::Result<Self> {
        let name = || format!("{}: cannot be used", path.display());
        let text = match fs::read(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
            other => other.with_context(name)?,
        };
        let rows = text.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice(line).ok()).collect();
        let mut file = OpenOptions::new().create(true).append(true).open(path).with_context(name)?;
        if text.last().is_some_and(|&byte| byte != b'\n') {
            file.write_all(b"\n").with_context(name)?;
        }
        Ok(Self { path: path.to_owned(), file, rows })
    }

    /// The run with this key, if it was made.
    pub(super) fn find(&self, key: &Key) -> Option<&Row> {
        self.rows.iter().rev().find(|row| row.key == *key)
    }

    /// Adds a run: one write, then to the disk.
    pub(super) fn add(&mut self, row: Row) -> anyhow::Result<()> {
        let line = serde_json::to_string(&row).context("cannot encode a result")? + "\n";
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.with_context(|| format!("{}: cannot be written", self.path.display()))?;
        self.rows.push(row);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{super::row::tests::row, *};

    #[test]
    fn what_was_added_is_found_again_even_after_a_cut() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let rows = [row("mlt", 1, 0.5), row("mlt", 2, 0.25), row("pt", 1, 0.125)];
        let mut journal = Journal::open(&path).expect("created");
        rows.iter().for_each(|row| journal.add(row.clone()).expect("added"));

        let text = fs::read(&path).expect("there");
        fs::write(&path, &text[..text.len() - 20]).expect("cut");
        let mut journal = Journal::open(&path).expect("opened");
        let found: Vec<bool> = rows.iter().map(|row| journal.find(&row.key) == Some(row)).collect();
        assert_eq!(found, [true, true, false]);

        journal.add(rows[2].clone()).expect("added");
        let journal = Journal::open(&path).expect("opened");
        assert!(rows.iter().all(|row| journal.find(&row.key) == Some(row)));
    }

    #[test]
    fn a_file_that_cannot_be_used_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |path: &Path| format!("{:#}", Journal::open(path).err().expect("refused"));
        assert!(message(folder.path()).contains("cannot be used"));
        assert!(message(&folder.path().join("none/a")).contains("none/a"));
    }
}
