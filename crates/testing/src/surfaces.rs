use glam::Vec3;
use gnomon_brdf::{Model, Surface};

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
