//! Materials that change while running.

use gnomon_scene::Scene;

use super::Renderer;
use crate::RenderError;
use crate::materials::Materials;

impl Renderer {
    /// Takes new material parameters of the scene that was set last, reflectance models among them, without an upload of its meshes or
    /// textures: for editing while running. A scene with other meshes, or meshes of other materials, is taken over whole.
    ///
    /// # Errors
    /// As [`Renderer::set_scene`].
    pub fn set_materials(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if !self.geometry.is_of(scene) {
            return self.set_scene(scene);
        }
        if !self.materials.rewrite(&self.gpu, scene) {
            self.materials = Materials::new(&self.gpu, &self.passes.gbuffer.material_layout, scene)?;
        }
        self.take_lobes(scene);
        self.gpu.check()
    }
}
