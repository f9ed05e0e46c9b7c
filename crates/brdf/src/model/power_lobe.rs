//! What Phong's lobe and Blinn's have in common: a matte part and a power of a cosine, just added.

use glam::Vec3;

use crate::{BASE_COLOR, Layers, Lobe, Parameter, SHININESS, SPECULAR, SPECULAR_COLOR, Surface};

pub const REQUIRED: &[&Parameter] = &[&SHININESS, &SPECULAR];
pub const OPTIONAL: &[&Parameter] = &[&BASE_COLOR, &SPECULAR_COLOR];

/// An interface that reflects everything, times the specular colour.
pub fn concerning(surface: Surface) -> Surface {
    Surface { metallic: 0.0, ior: 0.0, ..surface }
}

/// At its centre the lobe goes with the cosine to the light, which is that to the viewer.
pub fn cached(lobe: &Lobe, white: Vec3, cosines: f32) -> Vec3 {
    cosines * lobe.tint.truncate() * white
}

pub fn strength(layers: &Layers) -> Vec3 {
    layers.diffuse + layers.lobe.tint.truncate()
}
