//! A process that reads, watched by another.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use gnomon_fuzzing::Target;
use gnomon_fuzzing::mutation::{Random, mutated};
use gnomon_fuzzing::seeds::seeds;

/// Most memory [KiB], where the shell can bound it: two threads reserve a little of it.
const MOST_KIB: u64 = 2 << 20;
/// Time from one look to the next, and looks in the longest time for one file.
const PAUSE: Duration = Duration::from_millis(50);
const MOST_LOOKS: u32 = 200;

/// How a process ended.
pub enum Outcome {
    /// Its time was over.
    Survived,
    /// In a file.
    Ended {
        /// What happened, for people.
        how: String,
        /// A copy of it.
        file: PathBuf,
    },
}

/// Lets a process of this program read damaged files for a time; with the number of files.
///
/// # Errors
/// Processes or files that the system refuses.
pub fn watched(target: &Target, time: Duration, seed: u64, found: &Path) -> io::Result<(Outcome, u64)> {
    let folder = tempfile::tempdir()?;
    let progress = folder.path().join("progress");
    let messages = folder.path().join("messages");
    let mut child = start(target.name, time, seed, &progress, &messages)?;
    // Looks without progress are counted, not time: a machine that sleeps is no reader that hangs.
    let (mut seen, mut looks) = (None, 0);
    let how = loop {
        if let Some(status) = child.try_wait()? {
            break ended(status, &messages);
        }
        let number = std::fs::read(&progress).ok();
        looks = if number == seen { looks + 1 } else { 0 };
        seen = number;
        if looks > MOST_LOOKS {
            child.kill()?;
            child.wait()?;
            break Some(format!("more than {} s", (PAUSE * MOST_LOOKS).as_secs()));
        }
        std::thread::sleep(PAUSE);
    };
    let number = std::fs::read(&progress)?.try_into().map_or(0, u64::from_le_bytes);
    let Some(how) = how else { return Ok((Outcome::Survived, number + 1)) };
    // Damage is the same for the same seed.
    let seeds = seeds(target);
    let mut random = Random::new(seed);
    let bytes = (0..=number).map(|_| mutated(&seeds, &mut random)).last().unwrap_or_default();
    std::fs::create_dir_all(found)?;
    let file = found.join(format!("{}-{seed}-{number}", target.name));
    std::fs::write(&file, bytes)?;
    Ok((Outcome::Ended { how, file }, number + 1))
}

fn start(target: &str, time: Duration, seed: u64, progress: &Path, messages: &Path) -> io::Result<Child> {
    let program = std::env::current_exe()?;
    let mut command = if cfg!(unix) {
        let mut command = Command::new("sh");
        command.arg("-c").arg(format!("ulimit -v {MOST_KIB}; exec \"$0\" \"$@\"")).arg(program);
        command
    } else {
        Command::new(program)
    };
    command
        .args(["--target", target, "--seed", &seed.to_string()])
        .args(["--seconds", &time.as_secs().max(1).to_string()])
        .arg("--worker")
        .arg(progress)
        // Every thread reserves address space.
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(messages)?)
        .spawn()
}

/// What was wrong, if anything.
fn ended(status: ExitStatus, messages: &Path) -> Option<String> {
    if status.success() {
        return None;
    }
    let text = std::fs::read_to_string(messages).unwrap_or_default();
    let told: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).take(2).collect();
    Some(format!("{status}: {}", told.join(" ")))
}
