//! Attributes as lines of text, for formats that have comments only.

/// `name=value` on one line.
pub(super) fn line((name, value): &(String, String)) -> String {
    format!("{name}={}", value.replace('\\', r"\\").replace('\n', r"\n"))
}

/// A [`line`]'s name and value.
pub(super) fn pair(line: &str) -> Option<(String, String)> {
    let (name, text) = line.split_once('=')?;
    let mut value = String::new();
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            '\\' => value.push(if rest.next()? == 'n' { '\n' } else { '\\' }),
            c => value.push(c),
        }
    }
    Some((name.to_owned(), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_back() {
        for value in ["", "0.5", "a=b", "two\nlines", r"C:\new\n", "größe 門"] {
            let attribute = ("mlt.note".to_owned(), value.to_owned());
            assert!(!line(&attribute).contains('\n'));
            assert_eq!(pair(&line(&attribute)), Some(attribute));
        }
        assert_eq!([pair("a comment"), pair(r"a=\")], [None, None]);
    }
}
