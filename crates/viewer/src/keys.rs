//! What keys do.

use eframe::egui::{Key, KeyboardShortcut, Modifiers};

/// Something that a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Show or hide this help.
    Help,
    /// GPU picture, reference, their difference.
    NextPicture,
    /// The next debug view, or the one before.
    DebugView(i32),
    /// Another light for debug views of one.
    Light(i32),
    /// Turn the view by steps to the right and up.
    Turn(i32, i32),
    /// Move the view by steps to the right and up.
    Pan(i32, i32),
    /// Go nearer (negative) or further.
    Dolly(i32),
    /// Frame the scene.
    Frame,
    /// Turn the environment by steps.
    RotateEnvironment(i32),
    /// Brighter or darker by steps.
    Exposure(i32),
    /// Run or stop the animation.
    Play,
    /// Show or hide the panel.
    Panel,
    /// Time every pass.
    Times,
    /// Save the picture.
    SavePicture,
    /// Save the scene.
    SaveScene,
    /// Close the help, dismiss messages.
    Dismiss,
}

const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

const fn shifted(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

const fn command(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

/// Every key; those with more modifiers come first, because a key alone matches with any.
pub const KEYS: &[(KeyboardShortcut, Action)] = &[
    (command(Key::P), Action::SavePicture),
    (command(Key::S), Action::SaveScene),
    (shifted(Key::ArrowLeft), Action::Pan(-1, 0)),
    (shifted(Key::ArrowRight), Action::Pan(1, 0)),
    (shifted(Key::ArrowUp), Action::Pan(0, 1)),
    (shifted(Key::ArrowDown), Action::Pan(0, -1)),
    (shifted(Key::D), Action::DebugView(-1)),
    (shifted(Key::E), Action::Exposure(-1)),
    (shifted(Key::Slash), Action::Help),
    (plain(Key::Questionmark), Action::Help),
    (plain(Key::F1), Action::Help),
    (plain(Key::ArrowLeft), Action::Turn(-1, 0)),
    (plain(Key::ArrowRight), Action::Turn(1, 0)),
    (plain(Key::ArrowUp), Action::Turn(0, 1)),
    (plain(Key::ArrowDown), Action::Turn(0, -1)),
    (plain(Key::Plus), Action::Dolly(-1)),
    (plain(Key::Equals), Action::Dolly(-1)),
    (plain(Key::Minus), Action::Dolly(1)),
    (plain(Key::F), Action::Frame),
    (plain(Key::R), Action::NextPicture),
    (plain(Key::D), Action::DebugView(1)),
    (plain(Key::Comma), Action::Light(-1)),
    (plain(Key::Period), Action::Light(1)),
    (plain(Key::OpenBracket), Action::RotateEnvironment(-1)),
    (plain(Key::CloseBracket), Action::RotateEnvironment(1)),
    (plain(Key::E), Action::Exposure(1)),
    (plain(Key::Space), Action::Play),
    (plain(Key::P), Action::Panel),
    (plain(Key::T), Action::Times),
    (plain(Key::Escape), Action::Dismiss),
];

/// The help: what to press or do, and what it does.
pub const HELP: &[(&str, &str)] = &[
    ("drag", "turn around the scene"),
    ("Shift + drag, right or middle drag", "move the view"),
    ("wheel, two fingers, pinch", "go nearer or further"),
    ("Shift + wheel", "move the view"),
    ("arrows, Shift + arrows", "turn, move the view"),
    ("+  -", "nearer, further"),
    ("F, double click", "frame the scene"),
    ("drop a file", "open a model, scene or environment"),
    ("R", "GPU picture, reference, difference"),
    ("D, Shift + D", "next debug view, the one before"),
    (",  .", "light of debug views of one light"),
    ("[  ]", "turn the environment"),
    ("E, Shift + E", "brighter, darker"),
    ("Space", "run or stop the animation"),
    ("T", "time every pass"),
    ("P", "show or hide the panel"),
    ("Ctrl + P, Ctrl + S", "save picture, save scene"),
    ("Ctrl + plus, Ctrl + minus", "larger, smaller text"),
    ("Esc", "close the help, dismiss messages"),
    ("?, F1", "this help"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        for (i, (key, _)) in KEYS.iter().enumerate() {
            assert!(KEYS[..i].iter().all(|(other, _)| other != key), "{key:?} is there twice");
        }
    }

    #[test]
    fn a_key_alone_hides_none_with_modifiers() {
        for (i, (key, _)) in KEYS.iter().enumerate() {
            let hidden = KEYS[..i]
                .iter()
                .any(|(other, _)| other.logical_key == key.logical_key && other.modifiers.is_none());
            assert!(!hidden, "{key:?} can never be reached");
        }
    }
}
