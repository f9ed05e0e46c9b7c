//! What a page is told.

use gnomon_options::OptionError;
use gnomon_renderer::RenderError;
use gnomon_studio::StudioError;
use wasm_bindgen::JsValue;

/// Why something did not come about: one line for people.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// The library's reason.
    #[error(transparent)]
    Studio(#[from] StudioError),
    /// The canvas cannot be drawn on.
    #[error("the canvas cannot be drawn on: {0}")]
    Canvas(String),
    /// The page asked for what cannot be.
    #[error("{0}")]
    Request(String),
}

impl From<RenderError> for PageError {
    fn from(error: RenderError) -> Self {
        Self::Studio(error.into())
    }
}

impl From<OptionError> for PageError {
    fn from(error: OptionError) -> Self {
        Self::Studio(error.into())
    }
}

impl From<serde_json::Error> for PageError {
    fn from(error: serde_json::Error) -> Self {
        Self::Request(gnomon_messages::one_line(&error.to_string()))
    }
}

impl From<PageError> for JsValue {
    fn from(error: PageError) -> Self {
        js_sys::Error::new(&gnomon_messages::one_line(&error.to_string())).into()
    }
}
