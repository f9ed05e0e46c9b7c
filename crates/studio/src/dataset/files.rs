//! Files of items, and which of them are whole.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use gnomon_picture::atomic;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::StudioError;

/// Items that are written together, all or none of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unit(pub RangeInclusive<u64>);

/// The files of one item: what each name goes on with after the item's number, and its bytes. The line is the last.
pub type ItemFiles = Vec<(&'static str, Vec<u8>)>;

/// Where items go: a folder of files, or of tar archives that each hold so many items (WebDataset shards).
#[derive(Clone, Debug)]
pub struct DatasetFiles {
    folder: PathBuf,
    /// Items of an archive.
    shard: Option<u64>,
    /// Of everything that items depend on.
    digest: String,
}

/// What is written after the files of a unit: they are whole where it says so.
#[derive(Serialize, Deserialize)]
struct Note {
    digest: String,
    /// Names and bytes.
    files: BTreeMap<String, u64>,
    /// Items that could not be drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    failed: Vec<u64>,
    /// The line of a single item.
    #[serde(flatten)]
    line: Value,
}

fn stem(item: u64) -> String {
    format!("{item:06}")
}

impl DatasetFiles {
    /// Makes the folder, where it is not there.
    ///
    /// # Errors
    /// [`StudioError::Write`]; [`StudioError::Request`] for shards without items.
    pub fn new(folder: &Path, shard: Option<u64>, digest: String) -> Result<Self, StudioError> {
        if shard == Some(0) {
            return Err(StudioError::Request("a shard holds at least one item".to_owned()));
        }
        if folder.is_file() {
            return Err(StudioError::Request(format!("{} is a file: items need a folder", folder.display())));
        }
        let written = |source| StudioError::Write { path: folder.to_owned(), source };
        fs::create_dir_all(folder).map_err(written)?;
        Ok(Self { folder: folder.to_owned(), shard, digest })
    }

    /// The units of a range that are not whole, with `overwrite` all. Several runs may work on one folder at once, each on a range of its own.
    ///
    /// # Errors
    /// [`StudioError::Request`] where items of another manifest lie there, or for a range that cuts shards.
    pub fn missing(
        &self,
        range: RangeInclusive<u64>,
        items: u64,
        overwrite: bool,
    ) -> Result<Vec<Unit>, StudioError> {
        let (first, last) = (*range.start(), *range.end());
        let length = self.shard.unwrap_or(1);
        if first % length != 0 || (last + 1) % length != 0 && last + 1 != items {
            return Err(StudioError::Request(format!(
                "items {first} to {last} cut a shard of {length}: a range begins with the first item of a shard and ends with the last one of a shard"
            )));
        }
        let mut missing = Vec::new();
        for start in (first..=last).step_by(usize::try_from(length).unwrap_or(usize::MAX)) {
            let unit = Unit(start..=last.min(start.saturating_add(length - 1)));
            if overwrite || !self.is_whole(&unit)? {
                missing.push(unit);
            }
        }
        Ok(missing)
    }

    fn note(&self, unit: &Unit) -> PathBuf {
        self.folder.join(self.name(unit) + ".json")
    }

    fn name(&self, Unit(items): &Unit) -> String {
        match self.shard {
            None => stem(*items.start()),
            Some(_) => format!("{}-{}", stem(*items.start()), stem(*items.end())),
        }
    }

    fn is_whole(&self, unit: &Unit) -> Result<bool, StudioError> {
        let path = self.note(unit);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(source) => return Err(StudioError::Read { path, source }),
        };
        let note: Option<Note> = serde_json::from_str(&text).ok();
        let Some(note) = note.filter(|note| note.digest == self.digest) else {
            return Err(StudioError::Request(format!(
                "{} belongs to another manifest, adapter or version: choose another folder, or draw it anew with --overwrite",
                path.display()
            )));
        };
        let is_there = |(name, bytes): (&String, &u64)| {
            fs::metadata(self.folder.join(name)).is_ok_and(|meta| meta.len() == *bytes)
        };
        Ok(note.failed.is_empty() && note.files.iter().all(is_there))
    }

    /// Writes the items of a unit, in their order, and then that they are whole. Of a unit of one item that could not be drawn nothing is written.
    ///
    /// # Errors
    /// [`StudioError::Write`].
    pub fn finish(
        &self,
        unit: &Unit,
        items: Vec<(u64, ItemFiles, Value)>,
        failed: Vec<u64>,
    ) -> Result<(), StudioError> {
        let mut files = BTreeMap::new();
        let line = match self.shard {
            None => {
                let Some((item, parts, line)) = items.into_iter().next() else { return Ok(()) };
                for (part, bytes) in parts {
                    let name = stem(item) + part;
                    self.write(&self.folder.join(&name), |file| file.write_all(&bytes))?;
                    files.insert(name, bytes.len() as u64);
                }
                line
            }
            Some(_) => {
                let name = self.name(unit) + ".tar";
                let archive = archive(items)
                    .map_err(|source| StudioError::Write { path: self.folder.join(&name), source })?;
                self.write(&self.folder.join(&name), |file| file.write_all(&archive))?;
                files.insert(name, archive.len() as u64);
                Value::Object(serde_json::Map::new())
            }
        };
        let note = Note { digest: self.digest.clone(), files, failed, line };
        // Only maps with keys that are no strings can fail.
        let text = serde_json::to_string(&note).unwrap_or_default() + "\n";
        self.write(&self.note(unit), |file| file.write_all(text.as_bytes()))
    }

    fn write(
        &self,
        path: &Path,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), StudioError> {
        let write = |path: &Path| atomic::write::<io::Error>(path, fill);
        write(path).map_err(|source| StudioError::Write { path: path.to_owned(), source })
    }
}

/// A tar archive as WebDataset reads it: the files of an item have its number before the first dot and stand together. The same items make the same
/// bytes.
fn archive(items: Vec<(u64, ItemFiles, Value)>) -> io::Result<Vec<u8>> {
    let mut archive = tar::Builder::new(Vec::new());
    let mut add = |name: &str, bytes: &[u8]| {
        let mut header = tar::Header::new_ustar();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        archive.append_data(&mut header, name, bytes)
    };
    for (item, parts, line) in items {
        for (part, bytes) in parts {
            add(&(stem(item) + part), &bytes)?;
        }
        add(&(stem(item) + ".json"), (line.to_string() + "\n").as_bytes())?;
    }
    archive.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(number: u64) -> (u64, ItemFiles, Value) {
        (number, vec![(".png", vec![number as u8; 3])], serde_json::json!({ "item": number }))
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn what_is_whole_is_not_missing() {
        let folder = tempfile::tempdir().unwrap();
        let files = |digest: &str| DatasetFiles::new(folder.path(), None, digest.to_owned()).unwrap();
        let one = files("one");
        let missing = |files: &DatasetFiles| files.missing(0..=3, 4, false).unwrap();
        assert_eq!(missing(&one), [0, 1, 2, 3].map(|n| Unit(n..=n)));
        for number in [0, 1, 2] {
            one.finish(&Unit(number..=number), vec![item(number)], Vec::new()).unwrap();
        }
        one.finish(&Unit(3..=3), Vec::new(), vec![3]).unwrap();
        fs::write(folder.path().join("000001.png"), "truncated later").unwrap();
        fs::remove_file(folder.path().join("000002.png")).unwrap();
        assert_eq!(missing(&one), [1, 2, 3].map(|n| Unit(n..=n)));
        assert_eq!(
            names(folder.path()),
            ["000000.json", "000000.png", "000001.json", "000001.png", "000002.json"]
        );
        let error = files("two").missing(0..=3, 4, false).unwrap_err().to_string();
        assert!(error.contains("000000.json") && error.contains("--overwrite"), "{error}");
        assert_eq!(files("two").missing(0..=3, 4, true).unwrap().len(), 4);
        let line: Value =
            serde_json::from_slice(&fs::read(folder.path().join("000000.json")).unwrap()).unwrap();
        assert_eq!((&line["item"], &line["files"]["000000.png"]), (&0.into(), &3.into()));
    }

    #[test]
    fn shards_hold_whole_items_in_their_order_and_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let files = DatasetFiles::new(folder.path(), Some(2), "one".to_owned()).unwrap();
        assert_eq!(files.missing(0..=4, 5, false).unwrap(), [Unit(0..=1), Unit(2..=3), Unit(4..=4)]);
        for range in [1..=4, 0..=2] {
            assert!(files.missing(range, 5, false).unwrap_err().to_string().contains("cut a shard of 2"));
        }
        files.finish(&Unit(0..=1), vec![item(0), item(1)], Vec::new()).unwrap();
        files.finish(&Unit(2..=3), vec![item(2)], vec![3]).unwrap();
        assert_eq!(
            files.missing(0..=4, 5, false).unwrap(),
            [Unit(2..=3), Unit(4..=4)],
            "what failed is tried again"
        );
        let bytes = fs::read(folder.path().join("000000-000001.tar")).unwrap();
        assert_eq!(archive(vec![item(0), item(1)]).unwrap(), bytes);
        let mut read = tar::Archive::new(bytes.as_slice());
        let names: Vec<String> = read
            .entries()
            .unwrap()
            .map(|entry| entry.unwrap().path().unwrap().display().to_string())
            .collect();
        assert_eq!(names, ["000000.png", "000000.json", "000001.png", "000001.json"]);
    }
}
