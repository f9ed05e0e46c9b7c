//! What rays meet: the materials of triangles, and where their corners lie in textures.

use glam::{Vec2, Vec3, Vec4};
use gnomon_shaders::layout;
use gnomon_shaders::twin::gbuffer_packing::pack_rgb9e5;

use crate::geometry::PlacedMesh;
use crate::materials::{FarMaterials, Materials};
use crate::{Gpu, RenderError};

/// The surfaces of a ray scene's triangles on the GPU, see `hit_surface.wgsl`.
pub(crate) struct HitSurfaces {
    /// Two texels of each, in the order of the scene's triangles.
    pub triangles: wgpu::TextureView,
    pub materials: FarMaterials,
}

/// They as they are gathered.
pub(super) struct HitTriangles<'a> {
    materials: &'a Materials,
    texels: Vec<[u32; 4]>,
}

const ROW: u32 = 2 * layout::HIT_TRIANGLES_A_ROW;

impl<'a> HitTriangles<'a> {
    /// Of meshes with these materials.
    pub fn of(materials: &'a Materials) -> Self {
        Self { materials, texels: Vec::new() }
    }

    /// Adds a mesh's triangles in the given order.
    pub fn add(&mut self, place: &PlacedMesh<'_>, order: &[u32]) {
        let mesh = place.mesh;
        let material = self.materials.number(place.mesh.material.map(|material| material.0));
        let set = self.materials.color_set(material);
        let uv = |index: u32| mesh.uvs[set].get(index as usize).copied().unwrap_or(Vec2::ZERO);
        let color = |index: u32| mesh.colors.get(index as usize).copied().unwrap_or(Vec4::ONE).truncate();
        let shines = if mesh.shines { layout::HIT_SHINES } else { 0 };
        for &triangle in order {
            let corners = mesh.triangles[triangle as usize];
            let color = corners.map(color).into_iter().sum::<Vec3>() / 3.0;
            let [a, b, c] = corners.map(|index| uv(index).to_array().map(f32::to_bits));
            self.texels.push([material as u32 | shines, pack_rgb9e5(color), a[0], a[1]]);
            self.texels.push([b[0], b[1], c[0], c[1]]);
        }
    }

    /// # Errors
    /// [`RenderError::OverLimit`] for more than a texture holds.
    pub fn upload(mut self, gpu: &Gpu) -> Result<HitSurfaces, RenderError> {
        let texels = (self.texels.len() as u32).max(1);
        let (width, rows) = (texels.min(ROW), texels.div_ceil(ROW));
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if rows > limit || width > limit {
            return Err(RenderError::OverLimit {
                what: "triangles that reflections show",
                wanted: self.texels.len() as u64 / 2,
                limit: u64::from(limit) * u64::from(layout::HIT_TRIANGLES_A_ROW),
                adapter: gpu.adapter().name.clone(),
            });
        }
        self.texels.resize((rows * width) as usize, [0; 4]);
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let format = wgpu::TextureFormat::Rgba32Uint;
        let texture = gpu.texture("what rays meet", [width, rows, 1], 1, format, usage);
        gpu.write_texture_in_parts(&texture, [width, rows], bytemuck::cast_slice(&self.texels));
        let triangles = texture.create_view(&Default::default());
        Ok(HitSurfaces { triangles, materials: FarMaterials::new(gpu, self.materials) })
    }
}
