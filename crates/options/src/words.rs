//! Options in words.

use std::fmt::Write;

use crate::{Kind, OptionSpec, OptionValue, Options};

impl OptionSpec {
    /// What it may be, as the end of a sentence.
    pub fn allowed(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let mut allowed = match self.kind {
            Kind::Bool => "true or false".to_owned(),
            Kind::Whole { least, most: i64::MAX } => format!("a whole number from {least}{unit}"),
            Kind::Whole { least, most } => format!("a whole number from {least} to {most}{unit}"),
            Kind::PowerOfTwo { least, most } => format!("a power of two from {least} to {most}{unit}"),
            Kind::Number { least: f32::MIN, most: f32::MAX, .. } => {
                format!("a finite number [{}]", self.unit)
            }
            Kind::Number { least, most, closed: true } => format!("a number from {least} to {most}{unit}"),
            Kind::Number { least, most, closed: false } => {
                format!("a number above {least} and below {most}{unit}")
            }
            Kind::Angle => "a finite angle in degrees".to_owned(),
            Kind::Text => "a text".to_owned(),
            Kind::Choice(_) => format!("one of: {}", self.choice_names()),
            Kind::Size => "WIDTHxHEIGHT in pixels, as in 640x480".to_owned(),
            Kind::File => "the path of a file".to_owned(),
            Kind::Color => "one number or RED/GREEN/BLUE from 0, linear Rec. 709".to_owned(),
        };
        if !self.words.is_empty() {
            allowed += ", or ";
            allowed += &self.words.iter().map(|(word, _)| *word).collect::<Vec<_>>().join(", ");
        }
        if self.automatic.is_some() {
            allowed += ", or automatic";
        }
        allowed
    }

    fn choice_names(&self) -> String {
        self.choices().iter().map(|choice| choice.name).collect::<Vec<_>>().join(", ")
    }

    /// The default, in words.
    pub fn default_text(&self, default: &OptionValue) -> String {
        self.default_in_words(default).map_or_else(|| default.to_string(), str::to_owned)
    }

    fn default_in_words(&self, default: &OptionValue) -> Option<&'static str> {
        self.varies.or(self.automatic.filter(|_| *default == OptionValue::Automatic))
    }

    /// What it does, what it may be and what it is by default, in one paragraph.
    pub fn help_line(&self, default: &OptionValue) -> String {
        let help = self.help();
        let allowed = self.allowed();
        let allowed = allowed.strip_prefix("one of: ").unwrap_or(&allowed);
        format!("{} [{allowed}] [default: {}]", help.trim_end_matches('.'), self.default_text(default))
    }

    /// The same with a line for every choice.
    pub fn long_help(&self, default: &OptionValue) -> String {
        let mut text = self.help_line(default);
        for choice in self.choices().iter().filter(|choice| !choice.summary.is_empty()) {
            let _ = write!(text, "\n- {}: {}", choice.name, choice.summary);
        }
        text
    }

    /// Stands for a value in a usage line.
    pub fn value_name(&self) -> &'static str {
        match self.kind {
            Kind::Bool => "BOOL",
            Kind::Whole { .. } | Kind::PowerOfTwo { .. } => "N",
            Kind::Number { .. } => "X",
            Kind::Angle => "DEG",
            Kind::Text | Kind::Choice(_) => "NAME",
            Kind::Size => "WxH",
            Kind::File => "FILE",
            Kind::Color => "R/G/B",
        }
    }
}

/// Tables of options in Markdown, one for each table of a scene file: the outer one, called `name`, and those of groups. What has no
/// name is the scene file itself.
pub fn markdown(name: &str, settings: &dyn Options) -> String {
    let mut text = String::new();
    let mut table = None;
    settings.visit(&mut |spec, field| {
        let group = spec.group.table;
        if table != Some(group) {
            let path = match (name, group) {
                ("", _) => "key".to_owned(),
                (name, "") => format!("`[{name}]`"),
                (name, group) => format!("`[{name}.{group}]`"),
            };
            let space = if table.is_some() { "\n" } else { "" };
            let _ = writeln!(text, "{space}| {path} | value | default |\n|---|---|---|");
            table = Some(group);
        }
        let _ = writeln!(text, "{}", row(spec, &field.get()));
    });
    text
}

fn row(spec: &OptionSpec, default: &OptionValue) -> String {
    let allowed = match spec.kind {
        Kind::Choice(_) => {
            let names: Vec<String> =
                spec.choices().iter().map(|choice| format!("`\"{}\"`", choice.name)).collect();
            names.join(", ")
        }
        Kind::Size => "`[width, height]` in pixels".to_owned(),
        Kind::Color => "one number or `[red, green, blue]` from 0, linear Rec. 709".to_owned(),
        _ => spec.allowed(),
    };
    let default = match (spec.default_in_words(default), default) {
        (Some(words), _) => words.to_owned(),
        (None, OptionValue::Name(name)) => format!("`\"{name}\"`"),
        (None, OptionValue::Size([width, height])) => format!("`[{width}, {height}]`"),
        (None, OptionValue::Color([red, green, blue])) => format!("`[{red}, {green}, {blue}]`"),
        (None, value) => format!("`{value}`"),
    };
    let mut key = format!("`{}`", spec.key);
    let path = format!("{}-{}", spec.group.table, spec.key).replace('_', "-");
    if spec.name() != path.trim_start_matches('-') {
        let _ = write!(key, " (`--{}`)", spec.name());
    }
    if let Some(alias) = spec.alias.filter(|_| !spec.group.table.is_empty()) {
        let _ = write!(key, " (also `{}` in the outer table)", alias.replace('-', "_"));
    }
    format!("| {key} | {} {} | {default} |", spec.help(), sentence(&allowed))
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}
