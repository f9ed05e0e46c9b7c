use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};

use crate::{Executor, StudioError};

/// Background work of one kind, one piece at a time. Of requests that come while it works only the last is kept: it starts when the
/// running one has ended, so that a request every frame still gives results.
pub(crate) struct Job<I, O> {
    name: &'static str,
    work: fn(I) -> O,
    executor: Arc<dyn Executor>,
    running: Option<Receiver<O>>,
    waiting: Option<I>,
}

impl<I: Send + 'static, O: Send + 'static> Job<I, O> {
    /// `name` is what the task is called, and what an error calls its work.
    pub fn new(name: &'static str, work: fn(I) -> O, executor: Arc<dyn Executor>) -> Self {
        Self { name, work, executor, running: None, waiting: None }
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
        let finished = match self.running.as_ref()?.try_recv() {
            Ok(output) => Ok(output),
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(StudioError::Background(self.name)),
        };
        self.running = None;
        self.start();
        Some(finished)
    }

    /// Waits for the running work; `None` where none runs.
    pub fn wait(&mut self) -> Option<Result<O, StudioError>> {
        let receiver = self.running.take()?;
        let mut answer = receiver.try_recv();
        while matches!(answer, Err(TryRecvError::Empty)) && self.executor.run_slices() {
            answer = receiver.try_recv();
        }
        // What no slice answers a thread does.
        let finished = answer.or_else(|_| receiver.recv()).map_err(|_| StudioError::Background(self.name));
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
        // A task that is not run drops the sender, which `poll` tells as an error.
        let task = async move {
            // Nobody may be left to hear it.
            let _ = sender.send(work(input));
        };
        self.executor.spawn(self.name, Box::pin(task));
        self.running = Some(receiver);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Slices, Threads};

    #[test]
    fn the_running_request_and_the_last_one_are_answered() {
        let work = |(value, gate): (u32, Receiver<()>)| {
            let _ = gate.recv();
            2 * value
        };
        let mut job = Job::new("doubling", work, Arc::new(Threads));
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
    fn without_threads_work_is_done_when_it_is_waited_for_or_polled() {
        let executor = Arc::new(Slices::default());
        let mut job = Job::new("doubling", |value: u32| 2 * value, executor.clone());
        job.request(1);
        assert!(job.poll().is_none(), "nobody has run it");
        assert!(!executor.run_slices());
        assert_eq!(job.poll().unwrap().unwrap(), 2);
        job.request(2);
        job.request(3);
        assert_eq!(job.wait().unwrap().unwrap(), 4);
        assert_eq!(job.wait().unwrap().unwrap(), 6);
        assert!(job.wait().is_none());
    }

    #[test]
    fn a_panicking_thread_is_an_error() {
        let work = |(): ()| -> u32 { std::panic::resume_unwind(Box::new("planted")) };
        let mut job = Job::new("planted", work, Arc::new(Threads));
        job.request(());
        assert!(matches!(job.wait(), Some(Err(StudioError::Background("planted")))));
    }
}
