//! Names from files, in messages.

/// The most characters of a name that a message repeats.
const MOST_OF_A_NAME: usize = 60;

/// The most characters of a message.
pub const MOST_OF_A_MESSAGE: usize = 2000;

/// `text` as a terminal may show it: what controls it is escaped, and characters beyond the first `most` are left out.
///
/// Escaped are control characters, and the invisible ones that change the direction or the order of a line.
pub fn printable(text: &str, most: usize) -> String {
    let invisible = |c: char| {
        c.is_control()
            || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
    };
    let mut shown = String::new();
    let mut characters = text.chars();
    for c in characters.by_ref().take(most) {
        if invisible(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    if characters.next().is_some() {
        shown.push('…');
    }
    shown
}

/// A name from a file, for a message.
pub(crate) fn shown(name: &str) -> String {
    printable(name, MOST_OF_A_NAME)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_controls_a_terminal_is_escaped() {
        assert_eq!(shown("a\x1b[31m\nb\u{9b}\u{202e}"), "a\\u{1b}[31m\\nb\\u{9b}\\u{202e}");
        assert_eq!(shown("Wand \"Süd\", O'Neill\\日本 🙂"), "Wand \"Süd\", O'Neill\\日本 🙂");
    }

    #[test]
    fn a_long_name_is_cut() {
        assert_eq!(shown(&"ä".repeat(60)), "ä".repeat(60));
        assert_eq!(shown(&"ä".repeat(1 << 20)), "ä".repeat(60) + "…");
    }
}
