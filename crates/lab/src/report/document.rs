use std::io;
use std::path::{Path, PathBuf};

use gnomon_picture::{ContactSheet, ImageError, atomic};
use serde_json::{Value, json};

use super::{Plot, Table};

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The file system refused a file or the folder.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A picture could not be written.
    #[error(transparent)]
    Picture(#[from] ImageError),
}

/// One subject of a report.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Its key in JSON.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// Paragraphs under the heading: what was done, what stands in for what, what it shows.
    pub paragraphs: Vec<String>,
    /// Its tables.
    pub tables: Vec<Table>,
    /// Its plots.
    pub plots: Vec<Plot>,
    /// Its pictures.
    pub sheets: Vec<ContactSheet>,
}

/// A whole report: what it was made with, and its sections.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Heading.
    pub title: String,
    /// What it was made with (adapter, version, settings), by name.
    pub conditions: Vec<(String, String)>,
    /// What was found.
    pub sections: Vec<Section>,
}

impl Document {
    /// Writes `report.md`, `results.json`, and for every table `NAME.csv`, every plot `NAME.svg`, every sheet `NAME.png`, where a
    /// name is turned into letters, digits, `-` and `_`, and a repeated one is numbered. The folder is made if missing. Gives the
    /// files written, `report.md` first.
    ///
    /// # Errors
    /// [`ReportError`]. Every file is complete or not there.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| ReportError::Write { path: folder.to_owned(), source })?;
        let mut names = Names::default();
        let (mut pages, mut files) = (self.front(), Vec::new());
        let text = |name: &str, content: &str| -> Result<PathBuf, ReportError> {
            let path = folder.join(name);
            atomic::write::<io::Error>(&path, |file| file.write_all(content.as_bytes()))
                .map_err(|source| ReportError::Write { path: path.clone(), source })?;
            Ok(path)
        };
        for section in &self.sections {
            pages += &format!("\n## {}\n", section.title);
            for paragraph in &section.paragraphs {
                pages += &format!("\n{paragraph}\n");
            }
            for table in &section.tables {
                let file = names.unique(&table.name, "csv");
                files.push(text(&file, &table.to_csv())?);
                pages += &format!("\n**{}** ([{file}]({file}))\n\n{}", table.caption, table.to_markdown());
            }
            for plot in &section.plots {
                let file = names.unique(&plot.name, "svg");
                files.push(text(&file, &plot.to_svg())?);
                pages += &format!("\n![{}]({file})\n", plot.title);
            }
            for sheet in &section.sheets {
                let file = names.unique(&sheet.name, "png");
                let path = folder.join(&file);
                gnomon_picture::write(&path, &sheet.to_image())?;
                files.push(path);
                pages += &format!("\n![{}]({file})\n", sheet.title);
            }
        }
        let json = serde_json::to_string_pretty(&self.to_json()).unwrap_or_default() + "\n";
        files.insert(0, text("results.json", &json)?);
        files.insert(0, text("report.md", &pages)?);
        Ok(files)
    }

    /// All numbers: `{title, conditions: {...}, sections: [{name, title, paragraphs, tables, plots}]}`.
    pub fn to_json(&self) -> Value {
        let conditions: serde_json::Map<String, Value> =
            self.conditions.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
        let sections: Vec<Value> = self
            .sections
            .iter()
            .map(|section| {
                json!({
                    "name": section.name, "title": section.title, "paragraphs": section.paragraphs,
                    "tables": section.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
                    "plots": section.plots.iter().map(Plot::to_json).collect::<Vec<_>>(),
                })
            })
            .collect();
        json!({ "title": self.title, "conditions": conditions, "sections": sections })
    }

    /// Title and conditions in Markdown.
    fn front(&self) -> String {
        let mut table = Table::new("", "", &[("condition", ""), ("value", "")]);
        for (name, value) in &self.conditions {
            table.push([name.as_str().into(), value.as_str().into()]);
        }
        format!("# {}\n\n{}", self.title, table.to_markdown())
    }
}

/// File names in use.
#[derive(Default)]
struct Names(Vec<String>);

impl Names {
    fn unique(&mut self, name: &str, extension: &str) -> String {
        let safe = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
        let stem: String =
            if name.is_empty() { "unnamed".to_owned() } else { name.chars().map(safe).collect() };
        let mut file = format!("{stem}.{extension}");
        let mut number = 1;
        while self.0.contains(&file) {
            number += 1;
            file = format!("{stem}_{number}.{extension}");
        }
        self.0.push(file.clone());
        file
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;
    use gnomon_picture::Panel;

    use crate::report::Axis;

    fn document() -> Document {
        let mut table = Table::new("a/b", "Times", &[("time", "ms")]);
        table.push([1.5.into()]);
        let plot = Plot::new("a/b", "Plot", Axis::linear("x", ""), Axis::linear("y", ""));
        let mut sheet = ContactSheet::new("sheet", "Pictures", 1);
        sheet.panels.push(Panel::new("grey", RgbImage::filled(8, 8, Vec3::splat(0.5))));
        let section = Section {
            name: "cost".to_owned(),
            title: "Cost".to_owned(),
            paragraphs: vec!["Words.".to_owned()],
            tables: vec![table.clone(), table],
            plots: vec![plot],
            sheets: vec![sheet],
        };
        let conditions = vec![("adapter".to_owned(), "a|b".to_owned())];
        Document { title: "Report".to_owned(), conditions, sections: vec![section] }
    }

    #[test]
    fn every_link_leads_to_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let files = document().write(&folder.path().join("new/out")).unwrap();
        let names: Vec<_> = files.iter().map(|f| f.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["report.md", "results.json", "a_b.csv", "a_b_2.csv", "a_b.svg", "sheet.png"]);
        assert!(files.iter().all(|file| file.is_file()));
        let page = std::fs::read_to_string(&files[0]).unwrap();
        for name in &names[2..] {
            assert!(page.contains(&format!("({name})")), "{name} in {page}");
        }
        assert!(page.contains("a\\|b"));
        let json: Value = serde_json::from_str(&std::fs::read_to_string(&files[1]).unwrap()).unwrap();
        assert_eq!(json["sections"][0]["tables"][1]["rows"][0][0], 1.5);
        assert_eq!(json["conditions"]["adapter"], "a|b");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = document().write(&file.join("out")).unwrap_err().to_string();
        assert!(error.starts_with("cannot write ") && error.contains("out"), "{error}");
    }
}
