//! Where background work runs.

use std::future::poll_fn;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// Background work. It is `Pending` between slices, and asks at once to be polled again.
pub type Task = Pin<Box<dyn Future<Output = ()> + Send>>;

/// What runs the background work of a session: loading, fitting lights, tracing a reference. A host with a runtime of its own
/// passes its tasks on to that.
pub trait Executor: Send + Sync {
    /// Takes a task called `name` over. One that cannot be run is dropped, which whoever waits for it sees.
    fn spawn(&self, name: &'static str, task: Task);

    /// Gives every task one slice on the calling thread, where this executor has no other; whether any task is left.
    fn run_slices(&self) -> bool {
        false
    }
}

/// What suits the platform: [`Threads`], or [`Slices`] where there are none.
pub fn default_executor() -> Arc<dyn Executor> {
    #[cfg(not(target_arch = "wasm32"))]
    return Arc::new(Threads);
    #[cfg(target_arch = "wasm32")]
    return Arc::new(Slices::default());
}

/// A thread for every task.
#[cfg(not(target_arch = "wasm32"))]
#[derive(Clone, Copy, Debug, Default)]
pub struct Threads;

#[cfg(not(target_arch = "wasm32"))]
impl Executor for Threads {
    fn spawn(&self, name: &'static str, task: Task) {
        // Where no thread can be had the task is dropped with the closure.
        let _ = std::thread::Builder::new().name(name.to_owned()).spawn(move || pollster::block_on(task));
    }
}

/// No thread: tasks go on by a slice whenever the session is polled.
#[derive(Default)]
pub struct Slices(Mutex<Vec<Task>>);

impl Slices {
    fn take(&self) -> Vec<Task> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn put_back(&self, tasks: impl IntoIterator<Item = Task>) -> bool {
        let mut left = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        left.extend(tasks);
        !left.is_empty()
    }
}

impl Executor for Slices {
    fn spawn(&self, _: &'static str, task: Task) {
        self.put_back([task]);
    }

    fn run_slices(&self) -> bool {
        // Tasks may spawn others: the lock is not held meanwhile.
        let mut context = Context::from_waker(Waker::noop());
        let mut tasks = self.take();
        tasks.retain_mut(|task| task.as_mut().poll(&mut context).is_pending());
        self.put_back(tasks)
    }
}

/// Ends a slice.
pub(crate) async fn end_slice() {
    let mut is_next = false;
    poll_fn(|context| {
        if std::mem::replace(&mut is_next, true) {
            return Poll::Ready(());
        }
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[test]
    fn slices_are_run_one_at_a_time_and_by_nobody_else() {
        let executor = Arc::new(Slices::default());
        let count = Arc::new(AtomicU32::new(0));
        for slices in [1, 3] {
            let (count, inner) = (Arc::clone(&count), Arc::clone(&executor));
            executor.spawn(
                "counting",
                Box::pin(async move {
                    for _ in 1..slices {
                        count.fetch_add(1, Ordering::Relaxed);
                        end_slice().await;
                    }
                    count.fetch_add(10, Ordering::Relaxed);
                    inner.spawn("another", Box::pin(async {}));
                }),
            );
        }
        let counted = || count.load(Ordering::Relaxed);
        assert_eq!(counted(), 0);
        for (left, expected) in [(true, 11), (true, 12), (true, 22), (false, 22)] {
            assert_eq!((executor.run_slices(), counted()), (left, expected));
        }
    }

    #[test]
    fn a_thread_goes_on_by_itself() {
        let (send, receive) = std::sync::mpsc::channel();
        Threads.spawn(
            "sliced",
            Box::pin(async move {
                end_slice().await;
                let _ = send.send(std::thread::current().name().map(str::to_owned));
            }),
        );
        assert_eq!(receive.recv().unwrap().as_deref(), Some("sliced"));
    }
}
