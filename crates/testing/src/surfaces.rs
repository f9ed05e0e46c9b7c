use glam::Vec3;
use gnomon_brdf::{METALS, Model, Surface};

/// Models that have a glossy part.
pub fn glossy_models() -> impl Iterator<Item = Model> {
    Model::ALL.iter().copied().filter(|model| model.shape().is_some())
}

/// A surface of full specular strength whose lobe is about as wide as GGX's of `roughness`, as far as the model goes.
pub fn glossy_surface(model: Model, roughness: f32) -> Surface {
    let surface = Surface { model, specular: 1.0, ..Surface::default() };
    let Some(shape) = model.shape() else { return surface };
    let of = |value: f32| {
        let mut surface = surface;
        (shape.set)(&mut surface, Vec3::splat(value));
        surface
    };
    let width = |value| model.equivalent_roughness(&of(value).layers().lobe);
    let [mut least, mut most] = shape.range;
    // Lobes widen with a roughness, and narrow with an exponent.
    let widens = width(most) > width(least);
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        match (width(middle) < roughness) == widens {
            true => least = middle,
            false => most = middle,
        }
    }
    of(0.5 * (least + most))
}

/// Surfaces of every tabulated model that makes its tables: wide and narrow, round and elliptical, dielectrics and metals.
pub fn tabulated_surfaces() -> Vec<Surface> {
    let gold = METALS[3];
    let plain = Surface { base_color: Vec3::ZERO, specular: 1.0, ..Surface::default() };
    let metal = Surface { index: gold.index, extinction: gold.extinction, ..plain };
    let (beckmann, gaussian) = (Model::MicrofacetBeckmann, Model::MicrofacetGaussian);
    vec![
        Surface { model: gaussian, slope: 0.15, index: Vec3::splat(1.5), ..plain },
        Surface { model: gaussian, slope: 0.4, index: Vec3::splat(200.0), ..plain },
        Surface { model: beckmann, slope: 0.1, ..metal },
        Surface { model: beckmann, slope: 0.5, base_color: Vec3::splat(0.3), specular: 0.5, ..plain },
        Surface { model: beckmann, slope: 0.1, aspect: 4.0, ..metal },
        Surface { model: beckmann, slope: 0.4, aspect: 0.3, index: Vec3::splat(5.0), ..plain },
        Surface {
            model: Model::AnisotropicGgx,
            roughness: 0.4,
            anisotropy: 0.7,
            metallic: 1.0,
            base_color: Vec3::ONE,
            ..plain
        },
        Surface {
            model: Model::AnisotropicGgx,
            roughness: 0.6,
            anisotropy: 0.5,
            anisotropy_rotation: 0.6,
            ..plain
        },
        Surface { model: Model::Ward, slope: 0.15, aspect: 1.0, ..plain },
        Surface { model: Model::Ward, slope: 0.1, aspect: 4.0, ..plain },
        Surface { model: Model::Threads, shininess: 30.0, ..plain },
        Surface { model: Model::CosineLobe, shininess: 40.0, ..plain },
        Surface { model: Model::CosineLobe, shininess: 10.0, axes: Vec3::new(-1.0, -0.7, 0.8), ..plain },
    ]
}
