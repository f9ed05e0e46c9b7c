use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

use crate::StudioError;

/// Work of one kind on a thread, one piece at a time. Of requests that come while it works only the last is kept: it starts when the
/// running one has ended, so that a request every frame still gives results.
pub(crate) struct Job<I, O> {
    name: &'static str,
    work: fn(I) -> O,
    running: Option<Receiver<O>>,
    waiting: Option<I>,
}

impl<I: Send + 'static, O: Send + 'static> Job<I, O> {
    /// `name` is what the thread is called, and what an error calls its work.
    pub fn new(name: &'static str, work: fn(I) -> O) -> Self {
        Self { name, work, running: None, waiting: None }
    }

    /// Asks for work; replaces what waits.
    pub fn request(&mut self, input: I) {
        self.waiting = Some(input);
        self.start();
    }

    /// Whether anything runs or waits.
    pub fn is_busy(&self) -> bool {
        self.running.is_some() || self.waiting.is_some()
    }

    /// Drops what waits, and the answer to what runs.
    pub fn forget(&mut self) {
        (self.running, self.waiting) = (None, None);
    }

    /// Finished work, without waiting for any.
    pub fn poll(&mut self) -> Option<Result<O, StudioError>> {
        let receiver = self.running.as_ref()?;
        let finished = match receiver.try_recv() {
            Ok(output) => Ok(output),
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(StudioError::Thread(self.name)),
        };
        self.running = None;
        self.start();
        Some(finished)
    }

    /// Waits for the running work; `None` where none runs.
    pub fn wait(&mut self) -> Option<Result<O, StudioError>> {
        let finished = self.running.take()?.recv().map_err(|_| StudioError::Thread(self.name));
        self.start();
        Some(finished)
    }

    fn start(&mut self) {
        if self.running.is_some() {
            return;
        }
        let Some(input) = self.waiting.take() else { return };
        let (sender, receiver) = mpsc::channel();
        let work = self.work;
        // Where no thread can be had the sender is dropped, which `poll` tells as an error.
        let _ = thread::Builder::new().name(self.name.to_owned()).spawn(move || {
            // Nobody may be left to hear it.
            let _ = sender.send(work(input));
        });
        self.running = Some(receiver);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_running_request_and_the_last_one_are_answered() {
        let mut job = Job::new("doubling", |(value, gate): (u32, Receiver<()>)| {
            let _ = gate.recv();
            2 * value
        });
        assert!(job.poll().is_none() && job.wait().is_none());
        let gates: Vec<_> = (1..4)
            .map(|value| {
                let (open, gate) = mpsc::channel();
                job.request((value, gate));
                open
            })
            .collect();
        assert!(job.is_busy() && job.poll().is_none());
        drop(gates);
        assert_eq!(job.wait().unwrap().unwrap(), 2);
        assert_eq!(job.wait().unwrap().unwrap(), 6);
        assert!(!job.is_busy() && job.wait().is_none());
        let (open, gate) = mpsc::channel();
        job.request((4, gate));
        job.forget();
        assert!(!job.is_busy() && job.wait().is_none());
        drop(open);
    }

    #[test]
    fn a_panicking_thread_is_an_error() {
        let mut job = Job::new("planted", |(): ()| -> u32 { std::panic::resume_unwind(Box::new("planted")) });
        job.request(());
        assert!(matches!(job.wait(), Some(Err(StudioError::Thread("planted")))));
    }
}
