use glam::Vec3;

use crate::Equirect;

/// What the radiance around a scene is multiplied by, channel by channel. Maps, and what is made of them, stay as they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grade {
    /// All that lights.
    pub light: Vec3,
    /// What is seen behind the scene.
    pub background: Vec3,
}

impl Grade {
    /// Everything as it is.
    pub const NONE: Self = Self { light: Vec3::ONE, background: Vec3::ONE };
}

impl Default for Grade {
    fn default() -> Self {
        Self::NONE
    }
}

impl Equirect {
    /// The same map with its radiance multiplied, channel by channel, and without a backdrop.
    #[must_use]
    pub fn times(&self, factor: Vec3) -> Self {
        let mut radiance = self.radiance().clone();
        for texel in radiance.texels_mut() {
            *texel = (*texel * factor).min(Vec3::MAX);
        }
        Self::new(radiance)
    }
}
