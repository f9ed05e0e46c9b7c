#import types

// Of every pass that draws or reads surfaces. The last one is that of meshes without a material.
@group(GROUP_SURFACE) @binding(0) var<storage, read> materials: array<Material>;

// Share of the rays that a point of an alpha stops.
fn opacity_of(material: Material, alpha: f32) -> f32 {
    if material.alpha_cutoff == ALPHA_BLENDS {
        return saturate(alpha);
    }
    return select(1.0, 0.0, alpha < material.alpha_cutoff);
}
