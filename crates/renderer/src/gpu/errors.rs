//! Errors and loss of a device that may be somebody else's: scopes around this library's calls in place of handlers.

use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use crate::{Gpu, RenderError};

/// What is known to be wrong with a device.
#[derive(Default)]
pub(super) struct Faults {
    /// First error outside of all scopes, of a device that is this library's own.
    uncaptured: Option<String>,
    /// Why the device is gone.
    lost: Option<String>,
    /// Scopes whose errors are still to come, as in a browser.
    pending: Vec<PoppedScope>,
}

type PoppedScope = Pin<Box<dyn Future<Output = Option<wgpu::Error>> + Send>>;

/// Catches the errors of calls on this thread from its making until [`ErrorScopes::finish`], so that no handler is told of them.
#[must_use = "errors are lost unless the scopes are finished"]
pub(crate) struct ErrorScopes {
    gpu: Gpu,
    // Dropped from the first to the last: the one that was pushed last goes first.
    internal: wgpu::ErrorScopeGuard,
    out_of_memory: wgpu::ErrorScopeGuard,
    validation: wgpu::ErrorScopeGuard,
}

impl ErrorScopes {
    /// The first error that was caught. A browser tells it later: then it is that of the next call.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`], [`RenderError::Device`].
    pub fn finish(self) -> Result<(), RenderError> {
        let Self { gpu, internal, out_of_memory, validation } = self;
        let popped: [PoppedScope; 3] =
            [Box::pin(internal.pop()), Box::pin(out_of_memory.pop()), Box::pin(validation.pop())];
        locked(&gpu.faults).pending.extend(popped);
        gpu.check()
    }
}

impl Gpu {
    /// Begins to catch errors. Scopes end in the reverse order of their making.
    pub(crate) fn catch_errors(&self) -> ErrorScopes {
        let [validation, out_of_memory, internal] =
            [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal]
                .map(|filter| self.device.push_error_scope(filter));
        ErrorScopes { gpu: self.clone(), internal, out_of_memory, validation }
    }

    /// Takes the handlers of a device that is this library's own: errors that nobody caught would be panics.
    pub(super) fn handle_faults(&self) {
        let faults = Arc::clone(&self.faults);
        self.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            locked(&faults).uncaptured.get_or_insert(gnomon_messages::one_line(&error.to_string()));
        }));
        let faults = Arc::clone(&self.faults);
        self.device.set_device_lost_callback(move |reason, message| {
            locked(&faults).lost = Some(match reason {
                wgpu::DeviceLostReason::Destroyed => "it was destroyed".to_owned(),
                _ => gnomon_messages::one_line(&message),
            });
        });
    }

    /// The fault of the calls before, if any is known.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] where nothing can be drawn with this device any more, [`RenderError::Device`] for any other fault.
    pub fn check(&self) -> Result<(), RenderError> {
        let is_lost = self.is_lost();
        let mut faults = locked(&self.faults);
        let mut caught = None;
        let mut context = Context::from_waker(Waker::noop());
        faults.pending.retain_mut(|scope| match scope.as_mut().poll(&mut context) {
            Poll::Ready(error) => {
                caught = caught.take().or(error);
                false
            }
            Poll::Pending => true,
        });
        if let Some(reason) = &faults.lost {
            return Err(RenderError::DeviceLost { reason: reason.clone() });
        }
        if is_lost {
            let reason = "the program that opened it was told why".to_owned();
            return Err(RenderError::DeviceLost { reason });
        }
        let words = caught
            .map(|error| gnomon_messages::one_line(&error.to_string()))
            .or_else(|| faults.uncaptured.clone());
        words.map_or(Ok(()), |words| Err(RenderError::Device(words)))
    }

    /// wgpu tells of a loss only the handler of whoever opened the device; but then a new buffer cannot be mapped.
    fn is_lost(&self) -> bool {
        let scopes = self.catch_errors();
        let probe = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("probe"),
            size: 4,
            usage: wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        let is_lost = probe.get_mapped_range_mut(..).is_err();
        drop(scopes);
        is_lost
    }
}

fn locked(faults: &Mutex<Faults>) -> MutexGuard<'_, Faults> {
    faults.lock().unwrap_or_else(PoisonError::into_inner)
}
