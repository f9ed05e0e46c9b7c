//! Numbered pictures, and the document beside them that tells which of them are done and what they show.

use std::collections::{BTreeMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use gnomon_picture::atomic;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::StudioError;

/// Names of numbered pictures: `frames/name_####.png` is `frames/name_0012.png` for frame 12.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameFiles {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl FrameFiles {
    /// The last run of `#` in the file's name stands for the number, as many digits as there are `#`, or more where it has more. A name
    /// without gets `_####` before its extension.
    ///
    /// # Errors
    /// [`StudioError::Request`] for a path without a file name that is text.
    pub fn new(pattern: &Path) -> Result<Self, StudioError> {
        let name = pattern.file_name().and_then(OsStr::to_str).ok_or_else(|| {
            StudioError::Request(format!("{} is no name for numbered pictures", pattern.display()))
        })?;
        let folder = pattern.parent().unwrap_or(Path::new("")).to_owned();
        let (before, digits, after) = match name.rfind('#') {
            Some(last) => {
                let start = name[..last]
                    .rfind(|c| c != '#')
                    .map_or(0, |at| at + name[at..].chars().next().map_or(1, char::len_utf8));
                (name[..start].to_owned(), last + 1 - start, name[last + 1..].to_owned())
            }
            None => {
                let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
                let after = if extension.is_empty() { String::new() } else { format!(".{extension}") };
                (format!("{stem}_"), 4, after)
            }
        };
        Ok(Self { folder, before, digits, after })
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        self.folder.join(self.name(frame))
    }

    fn name(&self, frame: u32) -> String {
        format!("{}{frame:0digits$}{}", self.before, self.after, digits = self.digits)
    }

    /// The document beside the pictures. It has their name with the signs in it, so that every pattern has its own.
    pub fn manifest(&self) -> PathBuf {
        let signs = "#".repeat(self.digits);
        self.folder.join(format!("{}{signs}{}.sequence.json", self.before, self.after))
    }
}

/// What the pictures of a sequence show, and which of them are done.
#[derive(Serialize, Deserialize)]
struct Manifest {
    /// Of everything that the pixels depend on.
    digest: String,
    /// The same in words, for people.
    made_of: Value,
    /// Done: number and bytes.
    frames: BTreeMap<u32, u64>,
}

/// The drawing of a sequence, which can be broken off and taken up again.
#[derive(Debug)]
pub struct SequenceRun {
    files: FrameFiles,
    digest: String,
    made_of: Value,
    done: BTreeMap<u32, u64>,
    missing: Vec<u32>,
}

impl SequenceRun {
    /// Finds out which of `frames` are still to be drawn: those that an earlier run with the same digest has not finished. Makes the folder.
    /// With `overwrite` all are, whatever lies there.
    ///
    /// # Errors
    /// [`StudioError::Request`] where pictures of other settings lie under these names; files that cannot be read or written.
    pub fn open(
        files: FrameFiles,
        frames: RangeInclusive<u32>,
        (made_of, digest): (Value, String),
        overwrite: bool,
    ) -> Result<Self, StudioError> {
        if !files.folder.as_os_str().is_empty() {
            let path = files.folder.clone();
            fs::create_dir_all(&files.folder).map_err(|source| StudioError::Write { path, source })?;
        }
        let old = if overwrite { None } else { read_manifest(&files.manifest())? };
        let done = match old {
            Some(old) if old.digest == digest => old.frames,
            _ if overwrite => BTreeMap::new(),
            other => {
                let exists = |frame: &u32| files.path(*frame).exists();
                let noted = other.map(|old| old.frames).unwrap_or_default();
                if let Some(frame) = noted.into_keys().find(exists) {
                    return Err(others(&files.path(frame), "was drawn with other settings"));
                }
                if let Some(frame) = frames.clone().find(exists) {
                    return Err(others(&files.path(frame), "is there, but no document tells what it shows"));
                }
                BTreeMap::new()
            }
        };
        let is_whole = |frame: &u32| {
            let bytes = fs::metadata(files.path(*frame)).map(|meta| meta.len());
            done.get(frame).is_some_and(|expected| bytes.is_ok_and(|bytes| bytes == *expected))
        };
        let missing: Vec<u32> = frames.filter(|frame| !is_whole(frame)).collect();
        let run = Self { files, digest, made_of, done, missing };
        run.remove_unfinished();
        run.write_manifest()?;
        Ok(run)
    }

    /// Frames that are still to be drawn, in order.
    pub fn missing(&self) -> &[u32] {
        &self.missing
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        self.files.path(frame)
    }

    /// Notes that a frame's file is whole, beside those that other runs have noted meanwhile: several may draw frames of one sequence,
    /// each its own. Where two note at the same moment one note may be lost, and a later run draws that frame again.
    ///
    /// # Errors
    /// [`StudioError::Request`] where another run has begun a sequence of other settings under these names; files that cannot be read or
    /// written.
    pub fn finish(&mut self, frame: u32) -> Result<(), StudioError> {
        let path = self.files.path(frame);
        let bytes = fs::metadata(&path).map_err(|source| StudioError::Read { path, source })?.len();
        match read_manifest(&self.files.manifest())? {
            Some(noted) if noted.digest == self.digest => self.done.extend(noted.frames),
            Some(_) => return Err(others(&self.files.manifest(), "is by now that of another sequence")),
            None => {}
        }
        self.done.insert(frame, bytes);
        self.write_manifest()
    }

    fn write_manifest(&self) -> Result<(), StudioError> {
        let path = self.files.manifest();
        let manifest = Manifest {
            digest: self.digest.clone(),
            made_of: self.made_of.clone(),
            frames: self.done.clone(),
        };
        // Only maps with keys that are no strings or numbers can fail.
        let text = serde_json::to_string_pretty(&manifest).unwrap_or_default() + "\n";
        let write = || atomic::write::<io::Error>(&path, |file| file.write_all(text.as_bytes()));
        let result = match write() {
            // Another run that has just begun took the unfinished document for one that a killed run left.
            Err(error) if error.kind() == io::ErrorKind::NotFound => write(),
            result => result,
        };
        result.map_err(|source| StudioError::Write { path, source })
    }

    /// Removes what a killed run left beside the pictures that are now drawn again, and beside the document.
    fn remove_unfinished(&self) {
        let mut names: HashSet<OsString> =
            self.missing.iter().map(|&frame| self.files.name(frame).into()).collect();
        names.extend(self.files.manifest().file_name().map(OsStr::to_owned));
        let folder =
            if self.files.folder.as_os_str().is_empty() { Path::new(".") } else { &self.files.folder };
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if atomic::unfinished_of(&entry.file_name()).is_some_and(|name| names.contains(&name)) {
                // What cannot be removed does no harm.
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

fn others(path: &Path, what: &str) -> StudioError {
    StudioError::Request(format!(
        "{} {what}: choose another name, or draw it anew with --overwrite",
        path.display()
    ))
}

fn read_manifest(path: &Path) -> Result<Option<Manifest>, StudioError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(StudioError::Read { path: path.to_owned(), source }),
    };
    let manifest = serde_json::from_str(&text);
    manifest.map(Some).map_err(|_| others(path, "is no document of a sequence"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(digest: &str) -> (Value, String) {
        (Value::Null, digest.to_owned())
    }

    #[test]
    fn names_have_their_number_where_the_signs_are() {
        for (pattern, name, manifest) in [
            ("a/b_####.png", "a/b_0012.png", "a/b_####.png.sequence.json"),
            ("b.exr", "b_0012.exr", "b_####.exr.sequence.json"),
            ("#.png", "12.png", "#.png.sequence.json"),
            ("take#2_###.png", "take#2_012.png", "take#2_###.png.sequence.json"),
            ("\u{e9}##x.png", "\u{e9}12x.png", "\u{e9}##x.png.sequence.json"),
        ] {
            let files = FrameFiles::new(Path::new(pattern)).unwrap();
            assert_eq!(files.path(12), Path::new(name));
            assert_eq!(files.manifest(), Path::new(manifest));
        }
        assert_eq!(FrameFiles::new(Path::new("b_#.png")).unwrap().path(12345), Path::new("b_12345.png"));
        assert!(FrameFiles::new(Path::new("/")).is_err());
    }

    #[test]
    fn a_run_goes_on_where_the_one_before_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let files = FrameFiles::new(&folder.path().join("deep/x_##.png")).unwrap();
        let open =
            |frames, digest, overwrite| SequenceRun::open(files.clone(), frames, made(digest), overwrite);
        let mut run = open(0..=4, "one", false).unwrap();
        assert_eq!(run.missing(), [0, 1, 2, 3, 4]);
        for frame in [0, 1, 2] {
            fs::write(run.path(frame), "picture").unwrap();
            run.finish(frame).unwrap();
        }
        // Killed between a picture and its note, and while writing another.
        fs::write(run.path(3), "picture").unwrap();
        let part = folder.path().join("deep/.x_04.png.999-0.part");
        fs::write(&part, "pict").unwrap();
        fs::write(run.path(1), "truncated later").unwrap();
        let run = open(0..=4, "one", false).unwrap();
        assert_eq!(run.missing(), [1, 3, 4]);
        assert!(!part.exists());
        assert_eq!(open(2..=2, "one", false).unwrap().missing(), [0; 0]);

        let error = open(7..=9, "two", false).unwrap_err().to_string();
        assert!(error.contains("x_00.png") && error.contains("--overwrite"), "{error}");
        assert_eq!(open(0..=1, "two", true).unwrap().missing(), [0, 1]);
        // Nothing is known of the others any more.
        assert_eq!(open(0..=4, "two", false).unwrap().missing(), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn patterns_and_runs_beside_each_other_keep_their_notes() {
        let folder = tempfile::tempdir().unwrap();
        let open = |name: &str, frames, digest| {
            let files = FrameFiles::new(&folder.path().join(name)).unwrap();
            SequenceRun::open(files, frames, made(digest), false)
        };
        let draw = |run: &mut SequenceRun, frame| {
            fs::write(run.path(frame), "picture").unwrap();
            run.finish(frame)
        };
        let mut first = open("x_###.png", 0..=3, "one").unwrap();
        let mut second = open("x_###.png", 4..=5, "one").unwrap();
        let mut other = open("x-###.png", 0..=3, "two").unwrap();
        draw(&mut other, 0).unwrap();
        for frame in [0, 1] {
            draw(&mut first, frame).unwrap();
            draw(&mut second, frame + 4).unwrap();
        }
        assert_eq!(open("x_###.png", 0..=5, "one").unwrap().missing(), [2, 3]);
        assert_eq!(open("x-###.png", 0..=3, "two").unwrap().missing(), [1, 2, 3]);
        // The same file by another pattern; one that no run has noted; a sequence that is begun anew.
        for (name, digest) in [("x_##.png", "one"), ("x_###.png", "three")] {
            let files = FrameFiles::new(&folder.path().join(name)).unwrap();
            fs::write(files.path(123), "mine").unwrap();
            assert!(open(name, 123..=123, digest).is_err(), "{name}");
        }
        let files = FrameFiles::new(&folder.path().join("x_###.png")).unwrap();
        SequenceRun::open(files, 0..=0, made("three"), true).unwrap();
        let error = draw(&mut first, 2).unwrap_err().to_string();
        assert!(error.contains("another sequence") && error.contains("--overwrite"), "{error}");
    }

    #[test]
    fn what_a_killed_run_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        for name in [".x_###.png.sequence.json.7-0.part", ".x_001.png.7-1.part", ".mine.png.7-2.part"] {
            fs::write(folder.path().join(name), "half").unwrap();
        }
        let files = FrameFiles::new(&folder.path().join("x_###.png")).unwrap();
        SequenceRun::open(files, 0..=3, made("one"), false).unwrap();
        let left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert!(
            left.iter()
                .all(|name| !name.to_str().unwrap().ends_with(".part") || *name == ".mine.png.7-2.part")
        );
        assert!(folder.path().join(".mine.png.7-2.part").exists());
    }

    #[test]
    fn foreign_files_are_not_overwritten_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let files = FrameFiles::new(&folder.path().join("x.png")).unwrap();
        fs::write(files.path(3), "mine").unwrap();
        assert!(SequenceRun::open(files.clone(), 0..=3, made("one"), false).is_err());
        assert!(SequenceRun::open(files.clone(), 0..=2, made("one"), false).is_ok());
        fs::write(files.manifest(), "{").unwrap();
        let error = SequenceRun::open(files.clone(), 0..=2, made("one"), false).unwrap_err().to_string();
        assert!(error.contains("no document"), "{error}");
        assert!(SequenceRun::open(files, 0..=3, made("one"), true).is_ok());
    }
}
