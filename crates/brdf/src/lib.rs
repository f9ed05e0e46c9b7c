//! Reflectance models. One file a model; every function that a shader also has bears the shader's name.

mod surface;

pub use surface::Surface;
