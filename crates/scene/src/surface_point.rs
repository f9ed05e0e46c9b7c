//! What shading on the CPU reads at a hit: textures, vertex attributes and the normal map, all in mesh space.

use glam::{Affine3A, Mat3, Vec2, Vec3, Vec4};
use gnomon_brdf::Surface;

use crate::{AlphaMode, Material, Mesh, MeshId, Scene, TextureRef, WorldVertices, triangle_normal};

/// A surface point with every texture and vertex attribute evaluated.
///
/// Normals are unit vectors in *mesh* space: bring them to the world with [`normal_matrix`] and normalize. (The normal map is applied before that, so the same matrix serves tangent, bitangent and normal.)
/// Both point to the front face's side, the one from which the triangle runs counter-clockwise; who looks from
/// behind turns them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Reflectance parameters, within their ranges.
    pub surface: Surface,
    /// Interpolated vertex normal bent by the normal map.
    pub shading_normal: Vec3,
    /// Interpolated vertex normal.
    pub smooth_normal: Vec3,
    /// Normal of the clear coat: the interpolated vertex normal, bent by the coat's own normal map.
    pub coat_normal: Vec3,
    /// Interpolated tangent with the bitangent's sign in w, turned to the direction of an anisotropic lobe; zero where the mesh has none.
    pub tangent: Vec4,
    /// Normal of the triangle's plane; the shading normal where the triangle has no area.
    pub geometric_normal: Vec3,
    /// Both texture coordinate sets, zero where the mesh has none.
    pub uvs: [Vec2; 2],
    /// Emitted radiance, linear.
    pub emissive: Vec3,
    /// Share of the rays that stop here: 0 in the holes of an alpha mask, alpha where it blends.
    pub opacity: f32,
    /// Lit from both sides; otherwise the camera does not see the back.
    pub double_sided: bool,
}

impl Scene {
    /// Material of a mesh.
    pub fn material(&self, mesh: MeshId) -> &Material {
        static DEFAULT: std::sync::LazyLock<Material> = std::sync::LazyLock::new(Material::default);
        self.meshes[mesh.0].material.map_or(&*DEFAULT, |material| &self.materials[material.0])
    }

    /// Everything shading needs at a point of a triangle, `barycentrics` being the weights of its three corners
    /// (they sum to 1). The mesh and triangle must exist.
    pub fn surface_at(&self, mesh: MeshId, triangle: usize, barycentrics: Vec3) -> SurfacePoint {
        let Mesh { positions, normals, tangents, .. } = &*self.meshes[mesh.0];
        self.surface_of(mesh, (positions, normals, tangents), triangle, barycentrics)
    }

    /// The same of a mesh whose vertices are elsewhere, as [`Scene::world_vertices`] has them: both normals are in world
    /// space.
    pub fn surface_in_world(
        &self,
        mesh: MeshId,
        vertices: &WorldVertices,
        triangle: usize,
        barycentrics: Vec3,
    ) -> SurfacePoint {
        let WorldVertices { positions, normals, tangents } = vertices;
        self.surface_of(mesh, (positions, normals, tangents), triangle, barycentrics)
    }

    fn surface_of(
        &self,
        mesh: MeshId,
        (positions, normals, tangents): (&[Vec3], &[Vec3], &[Vec4]),
        triangle: usize,
        barycentrics: Vec3,
    ) -> SurfacePoint {
        let material = self.material(mesh);
        let mesh = &self.meshes[mesh.0];
        let corners = mesh.triangles[triangle].map(|index| index as usize);
        let uvs = mesh.uvs_at(corners, barycentrics);
        let base = self.base_color(material, mesh, corners, barycentrics, uvs);

        let mut surface = material.surface;
        surface.base_color = base.truncate().clamp(Vec3::ZERO, Vec3::ONE);
        if let Some(texture) = material.metallic_roughness_texture {
            let texel = self.linear(texture, uvs);
            surface.roughness *= texel.y;
            surface.metallic *= texel.z;
        }
        surface.roughness = surface.roughness.clamp(0.0, 1.0);
        surface.metallic = surface.metallic.clamp(0.0, 1.0);
        if let Some(texture) = material.specular_texture {
            surface.specular *= self.linear(texture, uvs).w;
        }
        if let Some(texture) = material.specular_color_texture {
            surface.specular_color *= self.srgb(texture, uvs).truncate();
        }
        if let Some(texture) = material.clearcoat_texture {
            surface.clearcoat *= self.linear(texture, uvs).x;
        }
        if let Some(texture) = material.clearcoat_roughness_texture {
            surface.clearcoat_roughness *= self.linear(texture, uvs).y;
        }
        if let Some(texture) = material.sheen_color_texture {
            surface.sheen_color *= self.srgb(texture, uvs).truncate();
        }
        if let Some(texture) = material.sheen_roughness_texture {
            surface.sheen_roughness *= self.linear(texture, uvs).w;
        }
        let mut emissive = material.emissive;
        if let Some(texture) = material.emissive_texture {
            emissive *= self.srgb(texture, uvs).truncate();
        }
        if material.emissive_vertex_colors {
            emissive *= mesh.color_at(corners, barycentrics).truncate();
        }

        let plane = triangle_normal(corners.map(|index| positions[index]));
        let interpolated = if normals.is_empty() {
            None
        } else {
            weighted(barycentrics, corners.map(|index| normals[index])).try_normalize()
        };
        let smooth = interpolated.or(plane).unwrap_or(Vec3::Y);
        let mut shading_normal = smooth;
        let mut tangent = Vec4::ZERO;
        if !tangents.is_empty() {
            let tangents = corners.map(|index| tangents[index]);
            tangent = weighted(barycentrics, tangents.map(Vec4::truncate)).extend(tangents[0].w);
        }
        if let (Some(texture), false) = (material.normal_texture, tangents.is_empty()) {
            let texel = self.linear(texture, uvs).truncate();
            shading_normal = perturb_normal(smooth, tangent, texel, material.normal_scale);
        }
        let mut coat_normal = smooth;
        if let (Some(texture), false) = (material.clearcoat_normal_texture, tangents.is_empty()) {
            let texel = self.linear(texture, uvs).truncate();
            coat_normal = perturb_normal(smooth, tangent, texel, material.clearcoat_normal_scale);
        }
        if let (Some(texture), false) = (material.anisotropy_texture, tangents.is_empty()) {
            tangent = turned_tangent(smooth, tangent, self.linear(texture, uvs));
        }
        SurfacePoint {
            surface,
            shading_normal,
            smooth_normal: smooth,
            coat_normal,
            tangent,
            geometric_normal: plane.unwrap_or(smooth),
            uvs,
            emissive,
            opacity: material.alpha_mode.opacity(base.w),
            double_sided: material.double_sided,
        }
    }

    /// Share of the rays that stop here: `surface_at(..).opacity` without the rest, for shadow rays.
    pub fn opacity_at(&self, mesh: MeshId, triangle: usize, barycentrics: Vec3) -> f32 {
        let material = self.material(mesh);
        if material.alpha_mode == AlphaMode::Opaque {
            return 1.0;
        }
        let mesh = &self.meshes[mesh.0];
        let corners = mesh.triangles[triangle].map(|index| index as usize);
        let uvs = mesh.uvs_at(corners, barycentrics);
        material.alpha_mode.opacity(self.base_color(material, mesh, corners, barycentrics, uvs).w)
    }

    /// Linear base colour and alpha: factor times texture times vertex colour.
    fn base_color(
        &self,
        material: &Material,
        mesh: &Mesh,
        corners: [usize; 3],
        barycentrics: Vec3,
        uvs: [Vec2; 2],
    ) -> Vec4 {
        let mut base = material.surface.base_color.extend(material.alpha);
        if let Some(texture) = material.base_color_texture {
            base *= self.srgb(texture, uvs);
        }
        base * mesh.color_at(corners, barycentrics)
    }

    fn linear(&self, texture: TextureRef, uvs: [Vec2; 2]) -> Vec4 {
        self.textures[texture.texture.0].sample_linear(texture.transform(uvs[texture.set]))
    }

    fn srgb(&self, texture: TextureRef, uvs: [Vec2; 2]) -> Vec4 {
        self.textures[texture.texture.0].sample_srgb(texture.transform(uvs[texture.set]))
    }
}

impl Mesh {
    fn color_at(&self, corners: [usize; 3], barycentrics: Vec3) -> Vec4 {
        if self.colors.is_empty() {
            return Vec4::ONE;
        }
        let [a, b, c] = corners.map(|index| self.colors[index]);
        barycentrics.x * a + barycentrics.y * b + barycentrics.z * c
    }

    fn uvs_at(&self, corners: [usize; 3], barycentrics: Vec3) -> [Vec2; 2] {
        self.uvs.each_ref().map(|set| {
            if set.is_empty() {
                return Vec2::ZERO;
            }
            let [a, b, c] = corners.map(|index| set[index]);
            barycentrics.x * a + barycentrics.y * b + barycentrics.z * c
        })
    }
}

/// A unit normal bent by a normal map's texel (RGB 0..1), as glTF 2.0, section 3.9.3 and 3.7.2.1 have it:
/// `n' = normalize(s x T + s y B + z N)` with `(x, y, z) = 2 texel - 1`, scale `s`, and `B = w (N x T)`.
///
/// `tangent` holds T (made orthogonal to the normal here) and the bitangent's sign in w. Where T is parallel to the
/// normal, or the texel is black, the normal comes back as it was.
pub fn perturb_normal(normal: Vec3, tangent: Vec4, texel: Vec3, scale: f32) -> Vec3 {
    let t = tangent.truncate();
    let Some(t) = (t - normal * normal.dot(t)).try_normalize() else { return normal };
    let b = normal.cross(t) * tangent.w;
    let local = 2.0 * texel - Vec3::ONE;
    (t * local.x * scale + b * local.y * scale + normal * local.z).try_normalize().unwrap_or(normal)
}

/// A tangent turned to the direction of an anisotropy texture's texel (`KHR_materials_anisotropy`); as it was where that has none.
pub fn turned_tangent(normal: Vec3, tangent: Vec4, texel: Vec4) -> Vec4 {
    let t = tangent.truncate();
    let across = (t - normal * normal.dot(t)).normalize_or_zero();
    let [x, y] = [2.0 * texel.x - 1.0, 2.0 * texel.y - 1.0];
    let turned = across * x + normal.cross(across) * (tangent.w * y);
    if turned.length_squared() > 1e-6 { turned.extend(tangent.w) } else { tangent }
}

/// Takes normals from mesh to world space; normalize the result. This is the cofactor matrix of the linear part, its
/// inverse transpose times its determinant's size: no division, so a transform that flattens a mesh is no special case.
/// In a mirroring transform it keeps the normal on the side that was the front.
pub fn normal_matrix(world_from_mesh: &Affine3A) -> Mat3 {
    let m = Mat3::from(world_from_mesh.matrix3);
    let cofactors =
        Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { -cofactors } else { cofactors }
}

/// -1 for a transform that mirrors, else 1: the bitangent's sign is multiplied by it.
///
/// glTF defines the bitangent in the mesh and does not say what a mirroring node does to it. Here the relief of a normal map is mirrored with
/// the shape, so that a mirrored node looks like the mirror image of the mesh, and like mirrored vertices would. Blender does so
/// (`node_normal_map` of its shaders turns the bitangent for objects of negative scale; Cycles bends the normal before it transforms it), Bevy
/// (`mesh_tangent_local_to_world`), and three.js where a mesh brings no tangents; where it does, three.js leaves the sign, and dents become
/// bumps.
pub fn mirror_sign(world_from_mesh: &Affine3A) -> f32 {
    if world_from_mesh.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 }
}

fn weighted(weights: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    weights.x * a + weights.y * b + weights.z * c
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine2, Affine3A};

    use super::*;
    use crate::{MaterialId, Node, Texture, TextureId, Wrap};

    /// One triangle in z = 0 with uv = xy, and one 2 x 1 texture.
    fn scene(texels: [[u8; 4]; 2], set_up: impl FnOnce(&mut Material, TextureRef)) -> Scene {
        let mut material = Material::default();
        material.surface.base_color = Vec3::ONE;
        set_up(&mut material, TextureRef { texture: TextureId(0), uv_from_mesh: Affine2::IDENTITY, set: 0 });
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        Scene {
            meshes: vec![Arc::new(Mesh {
                uvs: [positions.iter().map(|p| p.truncate()).collect(), Vec::new()],
                positions,
                normals: vec![Vec3::Z; 3],
                tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
                triangles: vec![[0, 1, 2]],
                material: Some(MaterialId(0)),
                ..Mesh::default()
            })],
            materials: vec![material],
            textures: vec![Arc::new(Texture {
                width: 2,
                height: 1,
                rgba8: texels.to_vec(),
                wrap: [Wrap::ClampToEdge; 2],
                nearest: true,
            })],
            nodes: vec![Node { meshes: vec![MeshId(0)], ..Node::default() }],
            ..Scene::default()
        }
    }

    const LEFT: Vec3 = Vec3::new(0.8, 0.1, 0.1);
    const RIGHT: Vec3 = Vec3::new(0.1, 0.8, 0.1);

    #[test]
    fn textures_multiply_their_factors() {
        let scene = scene([[255, 128, 64, 255], [0, 255, 255, 255]], |material, texture| {
            material.metallic_roughness_texture = Some(texture);
            material.surface.roughness = 0.5;
            material.surface.metallic = 1.0;
        });
        let left = scene.surface_at(MeshId(0), 0, LEFT).surface;
        assert!((left.roughness - 0.5 * 128.0 / 255.0).abs() < 1e-6);
        assert!((left.metallic - 64.0 / 255.0).abs() < 1e-6);
        let right = scene.surface_at(MeshId(0), 0, RIGHT).surface;
        assert!((right.roughness - 0.5).abs() < 1e-6);
        assert!((right.metallic - 1.0).abs() < 1e-6);
    }

    #[test]
    fn vertex_colors_multiply_the_base_color() {
        let mut scene = scene([[255; 4]; 2], |material, _| material.surface.base_color = Vec3::splat(0.5));
        Arc::make_mut(&mut scene.meshes[0]).colors =
            vec![Vec4::ONE, Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::ONE];
        let point = scene.surface_at(MeshId(0), 0, Vec3::new(0.5, 0.5, 0.0));
        assert!((point.surface.base_color - Vec3::new(0.5, 0.25, 0.25)).length() < 1e-6);
    }

    #[test]
    fn alpha_lets_rays_through() {
        let of = |mode| {
            scene([[255, 255, 255, 127], [255, 255, 255, 128]], |material, texture| {
                material.base_color_texture = Some(texture);
                material.alpha_mode = mode;
            })
        };
        let share = |texel: f32| texel / 255.0;
        for (mode, left, right) in [
            (AlphaMode::Opaque, 1.0, 1.0),
            (AlphaMode::Mask { cutoff: 0.5 }, 0.0, 1.0),
            (AlphaMode::Blend, share(127.0), share(128.0)),
        ] {
            let scene = of(mode);
            for (place, opacity) in [(LEFT, left), (RIGHT, right)] {
                assert_eq!(scene.opacity_at(MeshId(0), 0, place), opacity, "{mode:?}");
                assert_eq!(scene.surface_at(MeshId(0), 0, place).opacity, opacity, "{mode:?}");
            }
        }
    }

    #[test]
    fn a_normal_map_bends_towards_tangent_and_bitangent() {
        let scene = scene([[255, 128, 128, 255], [128, 255, 128, 255]], |material, texture| {
            material.normal_texture = Some(texture);
        });
        let left = scene.surface_at(MeshId(0), 0, LEFT);
        assert!((left.shading_normal - Vec3::X).length() < 1e-2, "{left:?}");
        assert_eq!(left.geometric_normal, Vec3::Z);
        assert!((scene.surface_at(MeshId(0), 0, RIGHT).shading_normal - Vec3::Y).length() < 1e-2);
    }

    #[test]
    fn the_normal_scale_and_bitangent_sign_count() {
        let texel = Vec3::new(0.5, 1.0, 1.0);
        let tangent = Vec4::new(1.0, 0.0, 0.0, -1.0);
        let bent = perturb_normal(Vec3::Z, tangent, texel, 0.5);
        // (0, -0.5, 1) normalized.
        assert!((bent - Vec3::new(0.0, -0.447_213_6, 0.894_427_2)).length() < 1e-6);
        assert_eq!(perturb_normal(Vec3::Z, tangent, texel, 0.0), Vec3::Z);
        assert_eq!(perturb_normal(Vec3::Z, Vec4::new(0.0, 0.0, 2.0, 1.0), texel, 1.0), Vec3::Z);
        assert_eq!(perturb_normal(Vec3::Z, tangent, Vec3::splat(0.5), 1.0), Vec3::Z);
    }

    #[test]
    fn normals_stay_perpendicular_under_any_transform() {
        let rotation = glam::Quat::from_rotation_y(0.7);
        for scale in [Vec3::new(1.0, 4.0, 0.3), Vec3::new(-1.0, 2.0, 1.0), Vec3::new(1.0, 1.0, 0.0)] {
            let affine = Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::ONE);
            let normal = Vec3::new(0.0, 0.6, 0.8);
            let across = Vec3::new(0.3, 0.8, -0.6);
            let world = normal_matrix(&affine) * normal;
            assert!(world.dot(affine.transform_vector3(across)).abs() < 1e-5, "{scale}");
            // The front stays the front.
            assert!(world.dot(affine.transform_vector3(normal)) >= 0.0, "{scale}");
        }
    }

    #[test]
    fn triangles_without_area_or_normals_still_have_a_normal() {
        let mut scene = scene([[255; 4]; 2], |_, _| ());
        Arc::make_mut(&mut scene.meshes[0]).positions = vec![Vec3::ZERO; 3];
        Arc::make_mut(&mut scene.meshes[0]).normals = vec![Vec3::ZERO; 3];
        let point = scene.surface_at(MeshId(0), 0, LEFT);
        assert!(point.shading_normal.is_normalized() && point.geometric_normal.is_normalized());
    }
}
