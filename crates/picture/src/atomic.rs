//! Files that are either complete or not there.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Distinguishes files that one process writes at the same time.
static COUNTER: AtomicU64 = AtomicU64::new(0);

/// Removes the unfinished file unless it was renamed into place, also when the writer panics.
struct Unfinished(Option<PathBuf>);

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(path) = self.0.take() {
            // Nothing more can be done for a file that cannot be removed; the error that led here is reported.
            let _ = fs::remove_file(path);
        }
    }
}

/// Writes `path` through `fill` so that a reader sees the old file or the whole new one, never a part: the content
/// goes to a file beside it, which is renamed at the end and removed if anything fails.
///
/// Something that exists and is not a regular file (`/dev/stdout`, a pipe) is written in place, as it cannot be renamed over.
///
/// # Errors
/// Whatever `fill` or the file system reports.
pub fn write<E: From<io::Error>>(
    path: impl AsRef<Path>,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let path = path.as_ref();
    // Follow a symbolic link, so that the link stays and its target is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if fs::metadata(&target).is_ok_and(|meta| !meta.is_file() && !meta.is_dir()) {
        return finish(OpenOptions::new().write(true).open(&target)?, fill);
    }
    let name = target
        .file_name()
        .filter(|_| !target.is_dir())
        .ok_or_else(|| io::Error::new(io::ErrorKind::IsADirectory, "this is a folder, not a file"))?;
    let mut beside = OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}-{}.part", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
    let beside = target.with_file_name(beside);

    let file = OpenOptions::new().write(true).create_new(true).open(&beside).map_err(|error| {
        // Of the file beside it, which nobody has named: file systems without room for any say that it is not there.
        let has_folder =
            beside.parent().is_some_and(|folder| folder.as_os_str().is_empty() || folder.is_dir());
        match error.kind() {
            io::ErrorKind::NotFound if has_folder => {
                io::Error::new(io::ErrorKind::PermissionDenied, "its folder takes no new files")
            }
            _ => error,
        }
    })?;
    let mut unfinished = Unfinished(Some(beside.clone()));
    finish(file, fill)?;
    fs::rename(&beside, &target)?;
    unfinished.0 = None;
    Ok(())
}

/// Of a file that [`write`] left unfinished because the process was killed, the name of the file that it was to become.
pub fn unfinished_of(name: &OsStr) -> Option<OsString> {
    let name = name.to_str()?.strip_prefix('.')?.strip_suffix(".part")?;
    let (name, number) = name.rsplit_once('.')?;
    let (process, count) = number.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (is_number(process) && is_number(count)).then(|| name.into())
}

fn finish<E: From<io::Error>>(
    file: File,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let mut writer = BufWriter::new(file);
    fill(&mut writer)?;
    // Dropping a BufWriter swallows the error of a full disk.
    Ok(writer.flush()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_finished_file_replaces_the_old_one() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        fs::write(&path, "old").unwrap();
        write::<io::Error>(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(dir.path()), ["a.json"]);
    }

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_no_other() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        fs::write(&path, "old").unwrap();
        let result = write::<io::Error>(&path, |w| {
            w.write_all(b"half of the new")?;
            Err(io::Error::other("planted"))
        });
        assert_eq!(result.unwrap_err().to_string(), "planted");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(dir.path()), ["a.json"]);
    }

    #[test]
    fn a_panicking_writer_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        let result = std::panic::catch_unwind(|| {
            write::<io::Error>(&path, |_| std::panic::resume_unwind(Box::new("planted")))
        });
        assert!(result.is_err());
        assert!(names(dir.path()).is_empty());
    }

    #[test]
    fn unfinished_files_tell_what_they_were_to_become() {
        let dir = tempfile::tempdir().unwrap();
        write::<io::Error>(dir.path().join("a.b.png"), |w| {
            let beside = names(dir.path());
            assert_eq!(unfinished_of(OsStr::new(&beside[0])).as_deref(), Some(OsStr::new("a.b.png")));
            w.write_all(b"x")
        })
        .unwrap();
        for name in ["a.png", ".a.png.part", ".a.png.1-x.part", "a.png.1-2.part", ".part"] {
            assert_eq!(unfinished_of(OsStr::new(name)), None, "{name}");
        }
    }

    #[test]
    fn a_folder_and_a_missing_folder_are_errors() {
        let dir = tempfile::tempdir().unwrap();
        assert!(write::<io::Error>(dir.path(), |w| w.write_all(b"x")).is_err());
        assert!(write::<io::Error>(dir.path().join("absent/a.json"), |w| w.write_all(b"x")).is_err());
    }
}
