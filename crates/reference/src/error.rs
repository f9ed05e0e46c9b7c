use thiserror::Error;

use crate::render::MAX_PIXELS;

/// Why there is no reference picture.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReferenceError {
    /// Width or height is 0.
    #[error("a picture of {width} x {height} pixels is empty: both sides must be at least 1")]
    EmptyPicture {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// More than [`MAX_PIXELS`].
    #[error(
        "a picture of {width} x {height} pixels is too large: the reference renders at most {MAX_PIXELS} pixels"
    )]
    PictureTooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// Zero samples per pixel.
    #[error("a picture needs samples: ask for 2 a pixel at least")]
    NoSamples,
    /// The camera's matrix or lens is unusable.
    #[error("the camera{} cannot be used: {reason}", named(.name))]
    BadCamera {
        /// The camera's name.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The environment map has no texels.
    #[error("the environment map has no texels")]
    EmptyEnvironment,
    /// More triangles than the BVH can number.
    #[error("the scene has {0} placed triangles, more than the reference can number")]
    TooManyTriangles(usize),
    /// The caller asked to stop.
    #[error("the reference was cancelled")]
    Cancelled,
}

/// A name as it follows what has it, where it has one.
fn named(name: &str) -> String {
    if name.is_empty() { String::new() } else { format!(" {name:?}") }
}
