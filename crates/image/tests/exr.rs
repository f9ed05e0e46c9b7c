//! OpenEXR files of other programs, damaged ones, and our own writer.

use std::path::PathBuf;

use gnomon_image::read;
use gnomon_testing::data_file;

fn files(folder: &str) -> Vec<PathBuf> {
    let Some(folder) = data_file(folder) else { return Vec::new() };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn every_damaged_file_ends_in_a_picture_or_one_line_of_error() {
    let damaged = files("bad_inputs/exr");
    for path in &damaged {
        let started = std::time::Instant::now();
        let outcome = read(path);
        let seconds = started.elapsed().as_secs_f32();
        println!(
            "{seconds:.2} s {}: {:?}",
            path.file_name().unwrap().display(),
            outcome.as_ref().map(|d| (d.image.width(), d.image.height())).map_err(|e| e.to_string())
        );
        if let Err(error) = outcome {
            let text = error.to_string();
            assert_eq!(text.lines().count(), 1, "{text}");
        }
        assert!(seconds < 10.0, "{} took {seconds} s", path.display());
    }
}
