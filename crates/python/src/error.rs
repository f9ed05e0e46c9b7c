//! Errors of the library as exceptions, with the sentence that the command says.

use gnomon::reference::ReferenceError;
use gnomon::renderer::RenderError;
use gnomon::studio::StudioError;
use gnomon_messages::with_causes;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::{PyErr, create_exception};

create_exception!(
    gnomon,
    Error,
    PyException,
    "What was asked for cannot be had; the text says why and what to do."
);
create_exception!(
    gnomon,
    DeviceLost,
    Error,
    "The graphics device is gone, as after a driver's reset. The renderer's next call opens it anew."
);

/// The exception of an error.
pub fn raised(error: impl Into<StudioError>) -> PyErr {
    let error = error.into();
    match &error {
        StudioError::Render(RenderError::DeviceLost { .. }) => DeviceLost::new_err(with_causes(&error)),
        StudioError::Reference(ReferenceError::Cancelled) => PyKeyboardInterrupt::new_err(()),
        _ => Error::new_err(with_causes(&error)),
    }
}

/// An exception of this layer's own.
pub fn refused(message: impl Into<String>) -> PyErr {
    Error::new_err(message.into())
}
