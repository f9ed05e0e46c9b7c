//! Programs that rigs are written for. A new one is a file here with its [`Target`], and a line in [`targets`].

mod babylon;
mod bevy;
mod blender;
mod gltf;
mod gnomon;
mod mitsuba;
mod mujoco;
mod three;
mod usd;

use crate::Rig;

/// A program that rigs are written for.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name on the command line.
    pub name: &'static str,
    /// Extensions of file names that stand for it; more than one program may write files of the first.
    pub extensions: &'static [&'static str],
    /// One line about it.
    pub summary: &'static str,
    /// What mirrors show there.
    pub reflections: Reflections,
    /// Most lights that it draws, if it has a limit.
    pub most_lights: Option<usize>,
    /// What it cannot say of a light, for a warning; empty for nothing.
    pub loses: &'static str,
    /// Format of its maps, by the extension of their names.
    pub map_extension: &'static str,
    text: fn(&Rig) -> String,
}

/// What mirrors show in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reflections {
    /// The lights, as areas, and the residual around them.
    Lights,
    /// The same; and the camera sees the whole map.
    LightsBeforeMap,
    /// A map that lights nothing else: the whole one, where lights leave nothing.
    OwnMap,
    /// The map that gives the ambient light: lights have to leave something in it.
    Ambient,
    /// Nothing.
    Nothing,
}

/// Every program, in the order of help texts. Of two that write files of one extension, a name with it stands for the first.
pub fn targets() -> &'static [Target] {
    &[
        gnomon::TARGET,
        usd::TARGET,
        usd::DISTANT,
        gltf::TARGET,
        blender::TARGET,
        mitsuba::TARGET,
        three::TARGET,
        babylon::TARGET,
        bevy::TARGET,
        mujoco::TARGET,
    ]
}

/// The program of this name.
pub fn by_name(name: &str) -> Option<&'static Target> {
    targets().iter().find(|target| target.name == name)
}

/// The program that file names with this extension stand for.
pub fn by_extension(extension: &str) -> Option<&'static Target> {
    let extension = extension.to_ascii_lowercase();
    targets().iter().find(|target| target.extensions.contains(&extension.as_str()))
}

impl Target {
    /// The fit that its rigs are made by where nobody says, and the number of lights: `None` for the fit's own, and for Gnomon's own fit.
    pub fn fit(&self) -> (Option<&'static str>, Option<usize>) {
        // A fit that tiles the map leaves nothing to be mirrored.
        ((self.reflections == Reflections::Ambient).then_some("disks"), self.most_lights)
    }

    /// The file's text.
    pub fn text(&self, rig: &Rig) -> String {
        (self.text)(rig)
    }
}

/// The lines of a comment, each after `mark`.
fn comment(rig: &Rig, mark: &str) -> String {
    rig.about.iter().map(|line| format!("{mark}{line}\n")).collect()
}

/// The same as what an XML comment may hold: no two hyphens beside one another, and characters that XML has (XML 1.0, sections 2.2 and 2.5).
fn xml_comment(rig: &Rig, mark: &str) -> String {
    let mut text = String::new();
    for character in comment(rig, mark).chars() {
        if character == '-' && text.ends_with('-') {
            text.push(' ');
        }
        let is_known = matches!(character, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..);
        text.push(if is_known { character } else { char::REPLACEMENT_CHARACTER });
    }
    text
}

/// Numbers with a blank or a comma between them, in the fewest digits that bring them back as 32-bit floats.
fn numbers(values: impl IntoIterator<Item = f64>, between: &str) -> String {
    // A whole number of a double's many digits would be noise.
    let digits = |value: f64| (value as f32).to_string();
    values.into_iter().map(digits).collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests;
