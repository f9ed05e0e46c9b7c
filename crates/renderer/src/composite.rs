//! Compositing rules, side by side on one interface: `composite(full, unshadowed, shadowed)` in WGSL, where the last
//! two are the fit: its lights and its ambient rest.

use gnomon_options::Choice;

use crate::RenderError;

/// How exact unshadowed light, the ambient rest and the lights' shadows become one picture.
#[derive(Debug, PartialEq, Eq)]
pub struct Compositing {
    /// Name for people and files.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// WGSL module that fills the slot `composite`.
    pub module: &'static str,
    /// Whether the rule looks at unshadowed light.
    pub(crate) needs_unshadowed: bool,
    /// Whether the picture is the sum of what each light gives it.
    pub(crate) is_sum: bool,
}

/// Every compositing rule.
pub const COMPOSITINGS: &[Compositing] = &[
    Compositing {
        name: "additive",
        summary: "ambient rest plus shadowed lights (Arbree 2005, Annen 2008)",
        module: "composite_additive",
        needs_unshadowed: false,
        is_sum: true,
    },
    Compositing {
        name: "subtractive",
        summary: "unshadowed light less what shadows take away (DeCoro 2008)",
        module: "composite_subtractive",
        needs_unshadowed: true,
        is_sum: false,
    },
    Compositing {
        name: "ratio",
        summary: "unshadowed light times the shadowed share of the fit (Heitz 2018)",
        module: "composite_ratio",
        needs_unshadowed: true,
        is_sum: true,
    },
];

/// The same as choices of an option.
pub(crate) fn choices() -> Vec<Choice> {
    COMPOSITINGS.iter().map(|rule| Choice { name: rule.name, summary: rule.summary }).collect()
}

/// The compositing rule called `name`.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub fn by_name(name: &str) -> Result<&'static Compositing, RenderError> {
    COMPOSITINGS.iter().find(|rule| rule.name == name).ok_or_else(|| RenderError::UnknownName {
        what: "compositing rule",
        name: name.to_owned(),
        choices: COMPOSITINGS.iter().map(|rule| rule.name).collect::<Vec<_>>().join(", "),
    })
}
