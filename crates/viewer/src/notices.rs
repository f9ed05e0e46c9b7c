//! Lines that tell the user what happened, until dismissed.

use std::time::{Duration, Instant};

/// How much a line matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Something was done; goes away by itself.
    Done,
    /// Something was repaired or ignored.
    Warning,
    /// Something did not work.
    Error,
}

/// One line.
#[derive(Clone, Debug)]
pub struct Notice {
    /// How much it matters.
    pub level: Level,
    /// One line of text.
    pub text: String,
    /// How often the same was said in a row.
    pub count: u32,
    since: Instant,
}

/// How long [`Level::Done`] stays.
const SHOWN_FOR: Duration = Duration::from_secs(6);
/// Most lines; the oldest go first, errors last.
const MOST: usize = 8;

/// The lines on display, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Notices(Vec<Notice>);

impl Notices {
    /// Adds a line; one that is there already is counted instead.
    pub fn add(&mut self, level: Level, text: &str) {
        let text = gnomon_messages::quoted(text);
        if let Some(same) = self.0.iter_mut().find(|notice| notice.text == text && notice.level == level) {
            same.count = same.count.saturating_add(1);
            same.since = Instant::now();
            return;
        }
        if self.0.len() >= MOST {
            let oldest = self.0.iter().position(|notice| notice.level != Level::Error).unwrap_or(0);
            self.0.remove(oldest);
        }
        self.0.push(Notice { level, text, count: 1, since: Instant::now() });
    }

    /// Adds an error with all its causes.
    pub fn error(&mut self, error: &dyn std::error::Error) {
        self.add(Level::Error, &gnomon_messages::with_causes(error));
    }

    /// The lines.
    pub fn lines(&self) -> &[Notice] {
        &self.0
    }

    /// Takes a line away.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.0.len() {
            self.0.remove(index);
        }
    }

    /// Takes all lines away.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Takes away what has been shown long enough; whether anything is left that will go by itself.
    pub fn expire(&mut self) -> bool {
        self.0.retain(|notice| notice.level != Level::Done || notice.since.elapsed() < SHOWN_FOR);
        self.0.iter().any(|notice| notice.level == Level::Done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_single_and_bounded_and_the_same_one_is_counted() {
        let mut notices = Notices::default();
        notices.add(Level::Error, "disk\n  full\x1b");
        notices.add(Level::Error, "disk full");
        assert_eq!((notices.lines().len(), notices.lines()[0].count), (1, 2));
        assert_eq!(notices.lines()[0].text, "disk full");
        notices.add(Level::Warning, &"ä".repeat(1000));
        assert!(notices.lines()[1].text.chars().count() < 410);
    }

    #[test]
    fn errors_are_the_last_to_go() {
        let mut notices = Notices::default();
        notices.add(Level::Error, "first");
        for i in 0..20 {
            notices.add(Level::Warning, &format!("warning {i}"));
        }
        assert_eq!(notices.lines().len(), MOST);
        assert_eq!(notices.lines()[0].text, "first");
        notices.dismiss(0);
        notices.dismiss(99);
        assert_eq!(notices.lines().len(), MOST - 1);
        notices.clear();
        assert!(notices.lines().is_empty() && !notices.expire());
    }

    #[test]
    fn causes_are_told_once() {
        #[derive(Debug, thiserror::Error)]
        #[error("cannot open x: {0}")]
        struct Outer(#[source] std::io::Error);
        let mut notices = Notices::default();
        notices.error(&Outer(std::io::Error::other("no such file")));
        assert_eq!(notices.lines()[0].text, "cannot open x: no such file");
    }
}
