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
        let scopes = self.gpu.catch_errors();
        if !self.geometry.is_of(scene) {
            return self.set_scene(scene);
        }
        if !self.materials.rewrite(&self.gpu, scene) {
            let materials = Materials::new(&self.gpu, &self.passes.gbuffer.material_layout, scene)?;
            self.take_materials(materials);
        }
        self.take_lobes(scene);
        scopes.finish()
    }

    /// Takes materials over that lie elsewhere on the GPU.
    pub(super) fn take_materials(&mut self, materials: Materials) {
        if let Some(target) = &mut self.target {
            self.passes.gbuffer.take_materials(&self.gpu, &mut target.gbuffer, &materials);
        }
        self.materials = materials;
    }
}
