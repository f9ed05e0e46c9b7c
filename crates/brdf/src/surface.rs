use glam::Vec3;

/// What a reflectance model needs to know of a surface point: glTF's metallic-roughness parameters with
/// `KHR_materials_specular`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear base colour, 0..1.
    pub base_color: Vec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, 0..1; GGX alpha is its square.
    pub roughness: f32,
    /// `specularFactor`: strength of the dielectric reflection; 0 is exactly Lambert.
    pub specular: f32,
    /// `specularColorFactor`: tint of the dielectric reflection at normal incidence; may exceed 1.
    pub specular_color: Vec3,
    /// Index of refraction of the dielectric (1.5 unless the file says otherwise).
    pub ior: f32,
}

impl Default for Surface {
    /// A grey matte surface: Lambert 0.5.
    fn default() -> Self {
        Self {
            base_color: Vec3::splat(0.5),
            metallic: 0.0,
            roughness: 1.0,
            specular: 0.0,
            specular_color: Vec3::ONE,
            ior: 1.5,
        }
    }
}
