use serde_json::{Value, json};

use super::number::significant;

/// One value of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A measured number.
    Number(f64),
    /// A whole number, written with all its digits.
    Count(u64),
    /// Nothing was measured.
    Missing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(u64::from(count))
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

impl Cell {
    /// For people: numbers with three significant digits.
    fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => significant(*number, 3),
            Self::Count(count) => count.to_string(),
            Self::Missing => "-".to_owned(),
        }
    }

    /// For programs: every digit.
    fn exact(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => number.to_string(),
            Self::Count(count) => count.to_string(),
            Self::Missing => String::new(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            // What is not finite becomes null: JSON lacks it.
            Self::Number(number) => json!(number),
            Self::Count(count) => json!(count),
            Self::Missing => Value::Null,
        }
    }

    fn is_text(&self) -> bool {
        matches!(self, Self::Text(_))
    }
}

/// Heading of a column.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Column {
    /// What stands in it.
    pub name: String,
    /// Its unit, empty for a pure number or words.
    pub unit: String,
}

impl Column {
    /// `name [unit]`, or the name alone.
    fn heading(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{} [{}]", self.name, self.unit) }
    }
}

/// Named columns with units, and rows of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Stem of its files' names.
    pub name: String,
    /// What it shows, one sentence.
    pub caption: String,
    columns: Vec<Column>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows; each column is its name and its unit (empty for none).
    pub fn new(name: impl Into<String>, caption: impl Into<String>, columns: &[(&str, &str)]) -> Self {
        let columns = columns
            .iter()
            .map(|&(name, unit)| Column { name: name.to_owned(), unit: unit.to_owned() })
            .collect();
        Self { name: name.into(), caption: caption.into(), columns, rows: Vec::new() }
    }

    /// Adds a row. A short one is filled up with [`Cell::Missing`]; a long one adds columns without a name.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        let mut row: Vec<Cell> = row.into_iter().collect();
        if row.len() > self.columns.len() {
            self.columns.resize(row.len(), Column::default());
            for earlier in &mut self.rows {
                earlier.resize(row.len(), Cell::Missing);
            }
        }
        row.resize(self.columns.len(), Cell::Missing);
        self.rows.push(row);
    }

    /// The headings.
    #[cfg(test)]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The rows, each as long as there are columns.
    #[cfg(test)]
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Comma-separated values with a heading line (RFC 4180, but for line ends of one character), numbers with every digit, what
    /// is missing as nothing.
    pub fn to_csv(&self) -> String {
        let headings = self.columns.iter().map(Column::heading).collect::<Vec<_>>();
        let rows = self.rows.iter().map(|row| row.iter().map(Cell::exact).collect::<Vec<_>>());
        std::iter::once(headings)
            .chain(rows)
            .map(|fields| fields.iter().map(|field| csv_field(field)).collect::<Vec<_>>().join(",") + "\n")
            .collect()
    }

    /// `{name, caption, columns: [{name, unit}], rows: [[...]]}`. What is missing or not finite is null.
    pub fn to_json(&self) -> Value {
        let columns: Vec<Value> =
            self.columns.iter().map(|column| json!({ "name": column.name, "unit": column.unit })).collect();
        let rows: Vec<Vec<Value>> =
            self.rows.iter().map(|row| row.iter().map(Cell::json).collect()).collect();
        json!({ "name": self.name, "caption": self.caption, "columns": columns, "rows": rows })
    }

    /// A Markdown table, numbers to the right. Empty without columns.
    pub fn to_markdown(&self) -> String {
        if self.columns.is_empty() {
            return String::new();
        }
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = line(self.columns.iter().map(|column| markdown_cell(&column.heading())).collect());
        let rule = |column| if self.holds_words(column) { ":--" } else { "--:" };
        text += &line((0..self.columns.len()).map(|column| rule(column).to_owned()).collect());
        for row in &self.rows {
            text += &line(row.iter().map(|cell| markdown_cell(&cell.shown())).collect());
        }
        text
    }

    /// Aligned columns for a terminal, numbers to the right. Empty without columns.
    pub fn to_text(&self) -> String {
        let headings: Vec<String> = self.columns.iter().map(|column| flat(&column.heading())).collect();
        let rows = self.rows.iter().map(|row| row.iter().map(|cell| flat(&cell.shown())).collect());
        let lines: Vec<Vec<String>> = std::iter::once(headings).chain(rows).collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|column| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0))
            .collect();
        let mut text = String::new();
        for line in &lines {
            let padded = line.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
                if self.holds_words(column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            let joined = padded.collect::<Vec<_>>().join("  ");
            if !joined.is_empty() {
                text += joined.trim_end();
                text.push('\n');
            }
        }
        text
    }

    /// A column is of words if any of its cells is.
    fn holds_words(&self, column: usize) -> bool {
        self.rows.iter().any(|row| row[column].is_text())
    }
}

fn csv_field(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) || field.starts_with(' ') || field.ends_with(' ') {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

fn markdown_cell(text: &str) -> String {
    flat(text).replace('\\', "\\\\").replace('|', "\\|")
}

/// One line.
fn flat(text: &str) -> String {
    text.chars().map(|character| if character.is_control() { ' ' } else { character }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table = Table::new("t", "A table", &[("technique", ""), ("time", "ms"), ("lights", "")]);
        table.push(["a, \"b\"".into(), 1.25.into(), 30_u32.into()]);
        table.push(["hard|x".into(), f64::NAN.into()]);
        table
    }

    #[test]
    fn csv_quotes_what_needs_it() {
        assert_eq!(sample().to_csv(), "technique,time [ms],lights\n\"a, \"\"b\"\"\",1.25,30\nhard|x,NaN,\n");
        let mut table = Table::new("t", "", &[("a\nb", "")]);
        table.push([" x".into()]);
        assert_eq!(table.to_csv(), "\"a\nb\"\n\" x\"\n");
    }

    #[test]
    fn json_has_null_for_what_is_not_a_number() {
        let json = sample().to_json();
        assert_eq!(json["columns"][1]["unit"], "ms");
        assert_eq!(json["rows"][0][1], 1.25);
        assert!(json["rows"][1][1].is_null() && json["rows"][1][2].is_null());
    }

    #[test]
    fn markdown_escapes_bars_and_aligns_numbers() {
        let text = sample().to_markdown();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "| :-- | --: | --: |");
        assert_eq!(lines[3], "| hard\\|x | NaN | - |");
    }

    #[test]
    fn text_is_aligned() {
        let text = sample().to_text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "technique  time [ms]  lights");
        assert_eq!(lines[1], "a, \"b\"          1.25      30");
        assert_eq!(lines[2], "hard|x           NaN       -");
    }

    #[test]
    fn an_empty_table_is_its_headings() {
        let table = Table::new("t", "", &[("a", "m")]);
        assert_eq!(table.to_csv(), "a [m]\n");
        assert_eq!(table.to_text(), "a [m]\n");
        let nothing = Table::new("t", "", &[]);
        assert_eq!(nothing.to_markdown() + &nothing.to_text(), "");
    }

    #[test]
    fn a_long_row_loses_nothing() {
        let mut table = Table::new("t", "", &[("a", "")]);
        table.push([1_u32.into()]);
        table.push([2_u32.into(), 3_u32.into()]);
        assert_eq!(table.rows()[0], [Cell::Count(1), Cell::Missing]);
        assert_eq!(table.rows()[1], [Cell::Count(2), Cell::Count(3)]);
        assert_eq!(table.columns().len(), 2);
    }
}
