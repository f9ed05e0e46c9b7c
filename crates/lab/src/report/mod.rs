//! What measurements become: tables, plots, contact sheets, and the folder that holds a whole report.
//!
//! A [`Table`] goes to CSV, JSON, Markdown and aligned text; a [`Plot`] to a self-contained SVG; a `ContactSheet` to one
//! picture. [`Document`] collects them in sections and writes them all, every file complete or not there.

mod document;
mod number;
mod plot;
mod regression;
mod table;

pub use document::{Document, ReportError, Section};
pub use number::significant;
pub use plot::{Axis, Plot, Series, Style};
pub use regression::{Line, PowerLaw};
pub use table::{Cell, Table};
