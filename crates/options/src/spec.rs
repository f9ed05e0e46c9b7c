//! What an option is.

use crate::{OptionError, OptionValue};

/// One option: everything that command line, scene file, panel and documentation say about it.
#[derive(Debug)]
pub struct OptionSpec {
    /// Name of the field, and of the key in a scene file.
    pub key: &'static str,
    /// What options it belongs to.
    pub group: &'static Group,
    /// What it may be.
    pub kind: Kind,
    /// Unit of a number; empty for a number without one.
    pub unit: &'static str,
    /// What it is when nobody says, for an option that may be left to the program.
    pub automatic: Option<&'static str>,
    /// A number that stands for what the program may come to, to begin with where somebody takes it in hand.
    pub start: f32,
    /// Words that stand for a number.
    pub words: &'static [(&'static str, f32)],
    /// Key of an option of the same settings that does not go together with this one.
    pub excludes: Option<&'static str>,
    /// The documentation of the field, as it stands there.
    documentation: &'static str,
    /// Name on the command line, where it is not made of the group's name and the key.
    flag: Option<&'static str>,
    /// Another key in the group's outer table, and name on the command line.
    pub alias: Option<&'static str>,
    heading: Option<&'static str>,
    condition: Option<Condition>,
    /// The default in words, where it is not the same for every scene.
    pub(crate) varies: Option<&'static str>,
}

/// Name of an option, and values.
pub type Condition = (&'static str, &'static [&'static str]);

/// Options that belong together.
#[derive(Debug)]
pub struct Group {
    /// Name of a table of its own in a scene file, and what names on the command line begin with; empty for none.
    pub table: &'static str,
    /// Heading in help and panel.
    pub heading: &'static str,
    /// The option that makes these matter, by its name, and the values that it has then.
    pub condition: Option<Condition>,
}

/// What an option may be.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Yes or no.
    Bool,
    /// A whole number within bounds.
    Whole {
        /// The smallest.
        least: i64,
        /// The largest.
        most: i64,
    },
    /// A power of two within bounds.
    PowerOfTwo {
        /// The smallest.
        least: i64,
        /// The largest.
        most: i64,
    },
    /// A number within bounds.
    Number {
        /// The lower bound.
        least: f32,
        /// The upper bound.
        most: f32,
        /// Whether it may be as small or as large as that.
        closed: bool,
    },
    /// Any angle [degrees]; whole turns more are the same.
    Angle,
    /// Any text.
    Text,
    /// One of a list that is asked for when it is needed.
    Choice(fn() -> Vec<Choice>),
    /// Width and height [pixels].
    Size,
    /// The path of a file: in a scene file seen from there, else from the working directory.
    File,
    /// Linear Rec. 709, no channel below 0.
    Color,
}

/// One value of an option that is chosen from a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Its name.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
}

const NO_GROUP: Group = Group { table: "", heading: "", condition: None };

const fn of_kind(kind: Kind) -> OptionSpec {
    OptionSpec {
        key: "",
        group: &NO_GROUP,
        kind,
        unit: "",
        automatic: None,
        start: 0.0,
        words: &[],
        excludes: None,
        documentation: "",
        flag: None,
        alias: None,
        heading: None,
        condition: None,
        varies: None,
    }
}

/// Yes or no.
pub const fn yes_no() -> OptionSpec {
    of_kind(Kind::Bool)
}

/// A whole number, bounds included.
pub const fn whole(least: i64, most: i64) -> OptionSpec {
    of_kind(Kind::Whole { least, most })
}

/// A power of two, bounds included.
pub const fn power_of_two(least: i64, most: i64) -> OptionSpec {
    of_kind(Kind::PowerOfTwo { least, most })
}

/// A number, bounds included.
pub const fn number(least: f32, most: f32) -> OptionSpec {
    of_kind(Kind::Number { least, most, closed: true })
}

/// A number, bounds excluded.
pub const fn between(least: f32, most: f32) -> OptionSpec {
    of_kind(Kind::Number { least, most, closed: false })
}

/// Any finite number of a unit.
pub const fn any_number(unit: &'static str) -> OptionSpec {
    number(f32::MIN, f32::MAX).unit(unit)
}

/// Any angle.
pub const fn angle() -> OptionSpec {
    of_kind(Kind::Angle).unit("degrees")
}

/// Any text.
pub const fn text() -> OptionSpec {
    of_kind(Kind::Text)
}

/// One of a list.
pub const fn choice(choices: fn() -> Vec<Choice>) -> OptionSpec {
    of_kind(Kind::Choice(choices))
}

/// Width and height.
pub const fn size() -> OptionSpec {
    of_kind(Kind::Size)
}

/// A file.
pub const fn file() -> OptionSpec {
    of_kind(Kind::File)
}

/// A color.
pub const fn color() -> OptionSpec {
    of_kind(Kind::Color)
}

impl OptionSpec {
    /// Its number's unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// It may be left to the program, which then does what `meaning` says, a number such as `start`.
    #[must_use]
    pub const fn automatic(self, meaning: &'static str, start: f32) -> Self {
        Self { automatic: Some(meaning), start, ..self }
    }

    /// A number that these words may stand for.
    #[must_use]
    pub const fn words(self, words: &'static [(&'static str, f32)]) -> Self {
        Self { words, ..self }
    }

    /// Giving it takes back `key`, and both at once are refused.
    #[must_use]
    pub const fn excludes(self, key: &'static str) -> Self {
        Self { excludes: Some(key), ..self }
    }

    /// Its name on the command line, where that is not the key's.
    #[must_use]
    pub const fn flag(self, flag: &'static str) -> Self {
        Self { flag: Some(flag), ..self }
    }

    /// Another name, without that of the group.
    #[must_use]
    pub const fn alias(self, alias: &'static str) -> Self {
        Self { alias: Some(alias), ..self }
    }

    /// Its default is not the same for every scene: `meaning` says what it is.
    #[must_use]
    pub const fn varies(self, meaning: &'static str) -> Self {
        Self { varies: Some(meaning), ..self }
    }

    /// Its heading, where that is not the group's.
    #[must_use]
    pub const fn under(self, heading: &'static str) -> Self {
        Self { heading: Some(heading), ..self }
    }

    /// It matters only where the option `name` has one of `values`.
    #[must_use]
    pub const fn only_for(self, name: &'static str, values: &'static [&'static str]) -> Self {
        Self { condition: Some((name, values)), ..self }
    }

    /// What [`crate::settings!`] knows of the field.
    #[doc(hidden)]
    #[must_use]
    pub const fn of_field(
        self,
        key: &'static str,
        documentation: &'static str,
        group: &'static Group,
    ) -> Self {
        Self { key, documentation, group, ..self }
    }

    /// Name on the command line, in the panel and wherever options are told apart.
    pub fn name(&self) -> String {
        match (self.flag, self.group.table) {
            (Some(flag), _) => flag.to_owned(),
            (None, "") => self.key.replace('_', "-"),
            (None, table) => format!("{table}-{}", self.key).replace('_', "-"),
        }
    }

    /// The key for people, beside the group's heading.
    pub fn label(&self) -> String {
        self.key.replace('_', " ")
    }

    /// Heading in help and panel.
    pub fn heading(&self) -> &'static str {
        self.heading.unwrap_or(self.group.heading)
    }

    /// The option that makes this one matter, by its name, and the values that it has then.
    pub fn condition(&self) -> Option<Condition> {
        self.condition.or(self.group.condition)
    }

    /// What it does, in one paragraph.
    pub fn help(&self) -> String {
        let words: Vec<&str> = self.documentation.split_whitespace().collect();
        words.join(" ")
    }

    /// The choices of a list.
    pub fn choices(&self) -> Vec<Choice> {
        match self.kind {
            Kind::Choice(choices) => choices(),
            _ => Vec::new(),
        }
    }

    /// `value` as this option's type has it.
    ///
    /// # Errors
    /// [`OptionError`] for what the option cannot be.
    pub fn accept(&self, value: OptionValue) -> Result<OptionValue, OptionError> {
        let number = match value {
            OptionValue::Whole(number) => Some(number as f32),
            OptionValue::Number(number) => Some(number),
            OptionValue::Name(ref name) => {
                self.words.iter().find(|(word, _)| word == name).map(|(_, number)| *number)
            }
            _ => None,
        };
        let accepted = match (self.kind, &value) {
            (_, OptionValue::Automatic) => self.automatic.map(|_| value.clone()),
            (Kind::Bool, OptionValue::Bool(_)) => Some(value.clone()),
            (Kind::Whole { least, most }, OptionValue::Whole(number)) => {
                (least..=most).contains(number).then(|| value.clone())
            }
            (Kind::PowerOfTwo { least, most }, OptionValue::Whole(number)) => {
                let is_power = u64::try_from(*number).is_ok_and(u64::is_power_of_two);
                (is_power && (least..=most).contains(number)).then(|| value.clone())
            }
            (Kind::Number { least, most, closed: true }, _) => {
                number.filter(|number| (least..=most).contains(number)).map(OptionValue::Number)
            }
            (Kind::Number { least, most, closed: false }, _) => {
                number.filter(|number| least < *number && *number < most).map(OptionValue::Number)
            }
            (Kind::Angle, _) => number.filter(|number| number.is_finite()).map(OptionValue::Number),
            (Kind::Text, OptionValue::Name(_)) => Some(value.clone()),
            (Kind::File, OptionValue::Name(path)) => (!path.is_empty()).then(|| value.clone()),
            (Kind::Choice(choices), OptionValue::Name(name)) => {
                choices().iter().any(|choice| choice.name == name).then(|| value.clone())
            }
            (Kind::Size, OptionValue::Size(sides)) => (!sides.contains(&0)).then(|| value.clone()),
            (Kind::Color, _) => {
                let grey = number.map(|number| [number; 3]);
                let color = if let OptionValue::Color(color) = value { Some(color) } else { grey };
                let is_color =
                    |color: &[f32; 3]| color.iter().all(|channel| (0.0..f32::INFINITY).contains(channel));
                color.filter(is_color).map(OptionValue::Color)
            }
            _ => None,
        };
        accepted.ok_or_else(|| self.refuse(&value.to_string()))
    }

    /// The value that a text stands for.
    ///
    /// # Errors
    /// As [`OptionSpec::accept`].
    pub fn parse(&self, text: &str) -> Result<OptionValue, OptionError> {
        let whole = text;
        let text = text.trim();
        let value = match self.kind {
            _ if self.automatic.is_some() && text == "automatic" => Some(OptionValue::Automatic),
            Kind::Bool => text.parse().ok().map(OptionValue::Bool),
            Kind::Whole { .. } | Kind::PowerOfTwo { .. } => text.parse().ok().map(OptionValue::Whole),
            Kind::Number { .. } | Kind::Angle => {
                let number = text.parse().ok().map(OptionValue::Number);
                number.or_else(|| (!self.words.is_empty()).then(|| OptionValue::Name(text.to_owned())))
            }
            Kind::Text | Kind::File => Some(OptionValue::Name(whole.to_owned())),
            Kind::Choice(_) => Some(OptionValue::Name(text.to_owned())),
            Kind::Size => text.split_once(['x', 'X']).and_then(|(width, height)| {
                Some(OptionValue::Size([width.parse().ok()?, height.parse().ok()?]))
            }),
            Kind::Color => {
                let channels: Option<Vec<f32>> =
                    text.split('/').map(|channel| channel.parse().ok()).collect();
                match channels.as_deref() {
                    Some([grey]) => Some(OptionValue::Number(*grey)),
                    Some(&[red, green, blue]) => Some(OptionValue::Color([red, green, blue])),
                    _ => None,
                }
            }
        };
        self.accept(value.ok_or_else(|| self.refuse(text))?)
    }

    fn refuse(&self, value: &str) -> OptionError {
        let value = value.split(|c: char| c.is_whitespace() || c.is_control()).collect::<Vec<_>>().join(" ");
        OptionError { option: self.name(), value: format!("`{value}`"), allowed: self.allowed() }
    }
}
