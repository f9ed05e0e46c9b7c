//! Options that are declared once.
//!
//! [`settings!`] declares a struct whose fields are options: type, default, range or choices, unit, and a help sentence that is the
//! field's documentation. [`choices!`] declares an enum whose variants are the choices of an option. Command line, scene file, panel
//! and documentation are made by whoever walks over [`Options`]; none of them names an option.
//!
//! [`Given`] holds the options that somebody gave, and only those. It is what a command line, a table of a scene file and the
//! difference of two settings have in common, and it is laid over settings: defaults first, then the scene file, then the command line.

mod choices;
mod error;
mod field;
mod given;
mod settings;
mod spec;
mod value;
mod words;

pub use error::OptionError;
pub use field::OptionField;
pub use given::Given;
pub use settings::{Options, matters, specs};
pub use spec::{
    Choice, Group, Kind, OptionSpec, angle, any_number, between, choice, color, file, number, power_of_two,
    size, text, whole, yes_no,
};
pub use value::OptionValue;
pub use words::markdown;

#[doc(hidden)]
pub use given::serialize;
#[doc(hidden)]
pub use serde;
