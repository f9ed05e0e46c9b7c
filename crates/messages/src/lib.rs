//! Messages for people, each on one line, whatever they quote: file names, contents of files and words of users may hold line ends,
//! escape sequences, and megabytes.

use std::error::Error;

/// Most bytes of a quotation, but for the mark of its cut.
const LONGEST: usize = 300;

/// The text with every run of white space and control characters as one space.
pub fn one_line(text: &str) -> String {
    words(text).collect::<Vec<_>>().join(" ")
}

/// The same, cut where it is long: for what comes from a file or a user.
pub fn quoted(text: &str) -> String {
    let mut line = String::new();
    for word in words(text) {
        if line.len() + word.len() > LONGEST {
            line.push(' ');
            line.extend(word.chars().take(LONGEST.saturating_sub(line.len())));
            line.push_str("...");
            break;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    line
}

/// An error and its causes. A cause that its effect already names is not said twice.
pub fn with_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if !text.contains(&words) {
            text = format!("{text}: {words}");
        }
        cause = error.source();
    }
    one_line(&text)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use std::fmt;
    use std::io;

    use super::*;

    #[test]
    fn text_becomes_one_line_and_a_quotation_a_bounded_one() {
        assert_eq!(one_line("a\n  b\t\u{1b}[31mc "), "a b [31mc");
        assert_eq!(quoted("a\n  b\t\u{1b}[31mc "), "a b [31mc");
        assert!(quoted(&format!("see {}", "9".repeat(10_000))).len() < 320);
        assert!(quoted(&"\u{e9} ".repeat(10_000)).len() < 320);
        assert_eq!(one_line(&"9".repeat(10_000)).len(), 10_000);
    }

    #[derive(Debug)]
    struct Outer(&'static str, io::Error);

    impl fmt::Display for Outer {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl Error for Outer {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.1)
        }
    }

    #[test]
    fn causes_are_joined_once() {
        let full = || io::Error::other("disk\nfull");
        assert_eq!(with_causes(&Outer("cannot write a.json", full())), "cannot write a.json: disk full");
        assert_eq!(with_causes(&Outer("disk\nfull at a.json", full())), "disk full at a.json");
    }
}
