//! Work without the interpreter's lock, which tells how far it has come and can be stopped.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use gnomon::studio::StudioError;
use pyo3::prelude::*;

use crate::error::{raised, refused};

/// How often the calling thread looks for Ctrl-C and for progress.
const PULSE: Duration = Duration::from_millis(20);

/// The process that worked first. Threads of a pool and handles of a driver do not survive a fork: a child that uses them hangs.
static WORKS_IN: OnceLock<u32> = OnceLock::new();

/// What work says and is told.
#[derive(Default)]
pub struct Job {
    cancel: AtomicBool,
    /// Bits of the share.
    share: AtomicU32,
}

impl Job {
    /// Tells the finished share, 0..1.
    pub fn tell(&self, share: f32) {
        self.share.store(share.to_bits(), Ordering::Relaxed);
    }

    /// Set once the work is to end early.
    pub fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }

    /// Whether it is.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    fn share(&self) -> f32 {
        f32::from_bits(self.share.load(Ordering::Relaxed))
    }
}

/// Does `work` on a thread while this one listens: to signals, and on behalf of `progress`, which is called with the finished share. What either
/// raises ends the work as soon as it can be ended, and is what this call raises.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Job) -> Result<T, StudioError> + Send,
) -> PyResult<T> {
    let process = std::process::id();
    if *WORKS_IN.get_or_init(|| process) != process {
        return Err(refused(
            "this process was forked from one that had used gnomon, whose threads and graphics device it does not have: start it with \
             multiprocessing's method 'spawn' or 'forkserver'",
        ));
    }
    let (job, done, caller) = (Job::default(), Mutex::new(None), thread::current());
    let mut raised_here = None;
    let mut told = 0.0;
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let result = work(&job);
            *done.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            caller.unpark();
        });
        while done.lock().unwrap_or_else(PoisonError::into_inner).is_none() && !worker.is_finished() {
            py.detach(|| thread::park_timeout(PULSE));
            if raised_here.is_some() {
                continue;
            }
            let share = job.share();
            let listened = py.check_signals().and_then(|()| match progress {
                Some(progress) if share != told => progress.call1((share,)).map(drop),
                _ => Ok(()),
            });
            told = share;
            if let Err(error) = listened {
                job.cancel.store(true, Ordering::Relaxed);
                raised_here = Some(error);
            }
        }
        // A panic is told below, by what is missing.
        let _ = py.detach(|| worker.join());
    });
    if let Some(error) = raised_here {
        return Err(error);
    }
    let result = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    let value = result.unwrap_or(Err(StudioError::Background("the work"))).map_err(raised)?;
    match progress {
        Some(progress) if told < 1.0 => progress.call1((1.0,)).map(|_| value),
        _ => Ok(value),
    }
}
