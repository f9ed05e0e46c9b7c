//! Materials that change while running.

use gnomon_scene::Scene;

use super::{CACHE_SAMPLES, Renderer};
use crate::RenderError;
use crate::materials::Materials;
use crate::radiance_cache::RadianceCache;

impl Renderer {
    /// Takes new material parameters of the scene that was set last, reflectance models among them, without an upload of its meshes or
    /// textures: for editing while running. A scene with other meshes, or meshes of other materials, is taken over whole.
    ///
    /// # Errors
    /// As [`Renderer::set_scene`].
    pub fn set_materials(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        if !self.geometry.is_of(scene) {
            return self.set_scene(scene);
        }
        if !self.materials.rewrite(&self.gpu, scene) {
            self.materials = Materials::new(&self.gpu, &self.passes.gbuffer.material_layout, scene)?;
        }
        self.cache_lobes(scene);
        scopes.finish()
    }

    /// Makes the radiance cache one of the scene's lobes.
    pub(super) fn cache_lobes(&mut self, scene: &Scene) {
        let wanted = self.compositing.needs_unshadowed;
        let lobes = if wanted { self.unshadowed.cached_lobes(scene) } else { Vec::new() };
        if self.cache.rewrite(&lobes) {
            return;
        }
        let resolution = self.settings.techniques.radiance_cache_resolution;
        self.cache = RadianceCache::new(&self.gpu, lobes, resolution, CACHE_SAMPLES);
        if let Some(mut lit) = self.lighting.take() {
            lit.environment = self.environment_groups(&lit.lighting);
            self.lighting = Some(lit);
        }
    }
}
