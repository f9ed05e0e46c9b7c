//! A file of user actions, to drive the window without a user: one action a line, `#` starts a comment.
//!
//! | line | does |
//! |---|---|
//! | `size WIDTH HEIGHT` | gives the window that size [points], and waits until it has it; goes on without where the system refuses |
//! | `key [Ctrl+][Shift+]KEY` | presses and releases a key |
//! | `drag left\|middle\|right X Y X Y` | drags from one place to another, in shares of the window |
//! | `scroll X Y LINES` | turns the wheel there |
//! | `click NAME` | clicks on a control of the panel |
//! | `choose NAME VALUE` | opens a list of the panel and clicks on an entry |
//! | `type TEXT` | replaces the text of the control that was clicked last, and ends with Enter |
//! | `drop PATH` | drops a file |
//! | `wait SECONDS`, `wait idle`, `wait samples N` | waits: so long; until nothing is being loaded and the picture is drawn; for the reference |
//! | `screenshot PATH.png` | writes the window's contents |
//! | `expect TEXT`, `expect no error` | fails unless a message holds the text, unless there is no error |
//! | `minimize`, `restore` | the window, and waits likewise |
//! | `lose device` | destroys the graphics device, as a driver's reset does |
//! | `quit` | closes the window |

use std::path::PathBuf;

use eframe::egui::{Key, Modifiers, PointerButton, Pos2};

/// Why a script cannot be run, or failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("script, line {line}: {message}")]
pub struct ScriptError {
    /// From 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

/// One action. Places are shares of the window's width and height.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the table above says what each does")]
pub enum Step {
    Size { width: f32, height: f32 },
    Key { key: Key, modifiers: Modifiers },
    Drag { button: PointerButton, from: Pos2, to: Pos2 },
    Scroll { at: Pos2, lines: f32 },
    Click { name: String },
    Choose { name: String, value: String },
    Type { text: String },
    Drop { path: PathBuf },
    Wait { seconds: f64 },
    WaitIdle,
    WaitSamples { count: u32 },
    Screenshot { path: PathBuf },
    Expect { text: String },
    ExpectNoError,
    Minimize,
    Restore,
    LoseDevice,
    Quit,
}

/// Reads a script: steps with their line numbers.
///
/// # Errors
/// The first line that is no action.
pub fn parse(text: &str) -> Result<Vec<(usize, Step)>, ScriptError> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    lines
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .map(|(line, text)| match step(text) {
            Ok(step) => Ok((line, step)),
            Err(message) => Err(ScriptError { line, message }),
        })
        .collect()
}

fn step(line: &str) -> Result<Step, String> {
    let (verb, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let words: Vec<&str> = rest.split_whitespace().collect();
    let expected = |what: &str| format!("'{line}' is no action: {verb} {what} is expected");
    match (verb, words.as_slice()) {
        ("size", [width, height]) => Ok(Step::Size {
            width: number(width, 1.0..=16384.0)? as f32,
            height: number(height, 1.0..=16384.0)? as f32,
        }),
        ("size", _) => Err(expected("WIDTH HEIGHT")),
        ("key", [chord]) => key(chord),
        ("key", _) => Err(expected("KEY")),
        ("drag", [button, from_x, from_y, to_x, to_y]) => Ok(Step::Drag {
            button: match *button {
                "left" => PointerButton::Primary,
                "middle" => PointerButton::Middle,
                "right" => PointerButton::Secondary,
                _ => return Err(format!("'{button}' is no button: left, middle or right")),
            },
            from: place(from_x, from_y)?,
            to: place(to_x, to_y)?,
        }),
        ("drag", _) => Err(expected("BUTTON X Y X Y")),
        ("scroll", [x, y, lines]) => {
            Ok(Step::Scroll { at: place(x, y)?, lines: number(lines, -100.0..=100.0)? as f32 })
        }
        ("scroll", _) => Err(expected("X Y LINES")),
        ("click", [_, ..]) => Ok(Step::Click { name: rest.to_owned() }),
        ("click", []) => Err(expected("NAME")),
        ("choose", [name, value @ ..]) if !value.is_empty() => {
            Ok(Step::Choose { name: (*name).to_owned(), value: value.join(" ") })
        }
        ("choose", _) => Err(expected("NAME VALUE")),
        ("type", _) => Ok(Step::Type { text: rest.to_owned() }),
        ("drop", [_, ..]) => Ok(Step::Drop { path: rest.into() }),
        ("drop", []) => Err(expected("PATH")),
        ("wait", ["idle"]) => Ok(Step::WaitIdle),
        ("wait", ["samples", count]) => Ok(Step::WaitSamples { count: number(count, 1.0..=1e6)? as u32 }),
        ("wait", [seconds]) => Ok(Step::Wait { seconds: number(seconds, 0.0..=3600.0)? }),
        ("wait", _) => Err(expected("SECONDS, idle or samples N")),
        ("screenshot", [_, ..]) if rest.ends_with(".png") => Ok(Step::Screenshot { path: rest.into() }),
        ("screenshot", _) => Err(expected("PATH.png")),
        ("expect", ["no", "error"]) => Ok(Step::ExpectNoError),
        ("expect", [_, ..]) => Ok(Step::Expect { text: rest.to_owned() }),
        ("expect", []) => Err(expected("TEXT or no error")),
        ("minimize", []) => Ok(Step::Minimize),
        ("restore", []) => Ok(Step::Restore),
        ("lose", ["device"]) => Ok(Step::LoseDevice),
        ("quit", []) => Ok(Step::Quit),
        _ => Err(format!("'{line}' is no action")),
    }
}

fn number(text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(format!("'{text}' is no number from {} to {}", range.start(), range.end())),
    }
}

fn place(x: &str, y: &str) -> Result<Pos2, String> {
    Ok(Pos2::new(number(x, 0.0..=1.0)? as f32, number(y, 0.0..=1.0)? as f32))
}

fn key(chord: &str) -> Result<Step, String> {
    let mut modifiers = Modifiers::NONE;
    let mut name = chord;
    loop {
        let (modifier, rest) = match name.split_once('+') {
            Some((first, rest)) if !rest.is_empty() => (first, rest),
            _ => break,
        };
        modifiers |= match modifier {
            "Ctrl" => Modifiers { ctrl: true, command: true, ..Modifiers::NONE },
            "Shift" => Modifiers::SHIFT,
            "Alt" => Modifiers::ALT,
            _ => return Err(format!("'{modifier}' is no modifier: Ctrl, Shift or Alt")),
        };
        name = rest;
    }
    let key = Key::from_name(name).ok_or_else(|| format!("'{name}' is no key"))?;
    Ok(Step::Key { key, modifiers })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_is_read() {
        let text = "# a session\nsize 640 480\nkey Ctrl+S\nkey Shift+D\nkey +\ndrag left 0.5 0.5 0.7 0.4\nscroll 0.5 0.5 -2\n\
                    click save picture\nchoose shadows pcf\ntype out.png\ndrop a b.glb\nwait 0.5\nwait idle\nwait samples 4\n\
                    screenshot a.png\nexpect cannot read\nexpect no error\nminimize\nrestore\nlose device\n\nquit\n";
        let steps = parse(text).unwrap();
        assert_eq!(steps.len(), 20);
        assert_eq!(steps[0], (2, Step::Size { width: 640.0, height: 480.0 }));
        let save = Modifiers { ctrl: true, command: true, ..Modifiers::NONE };
        assert_eq!(steps[1].1, Step::Key { key: Key::S, modifiers: save });
        assert_eq!(steps[3].1, Step::Key { key: Key::Plus, modifiers: Modifiers::NONE });
        assert_eq!(steps[9].1, Step::Drop { path: "a b.glb".into() });
    }

    #[test]
    fn a_wrong_line_is_named() {
        for (text, part) in [
            ("size 640", "WIDTH HEIGHT"),
            ("\nsize 0 480", "'0' is no number from 1"),
            ("key Strg+S", "'Strg' is no modifier"),
            ("key Any", "'Any' is no key"),
            ("drag up 0 0 1 1", "'up' is no button"),
            ("drag left 0 0 1 1.5", "'1.5'"),
            ("scroll 0 0 nan", "'nan'"),
            ("choose shadows", "NAME VALUE"),
            ("wait", "SECONDS"),
            ("screenshot a.jpg", "PATH.png"),
            ("dance", "'dance' is no action"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.message.contains(part), "{text}: {error}");
            assert_eq!(error.line, text.lines().count());
        }
    }
}
