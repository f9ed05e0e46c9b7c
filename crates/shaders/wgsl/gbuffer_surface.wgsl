#import sample_places
#import brdf_models
#import finish
#import gbuffer_packing
#import materials

// What is seen through the samples of the picture.

@group(GROUP_SURFACE) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(GROUP_SURFACE) @binding(2) var gbuffer_geometry: texture_2d<u32>;
@group(GROUP_SURFACE) @binding(3) var gbuffer_reflectance: texture_2d<u32>;

struct Surface {
    position_world: vec3f,
    // Shading and geometric normal, towards the viewer, and the direction to the viewer.
    n: vec3f,
    geometric_normal: vec3f,
    wo: vec3f,
    // Tangent frame about n.
    frame: Frame,
    // Albedo of the matte part.
    diffuse_color: vec3f,
    // Tint of the interface above the matte part, for models that have one.
    interface_tint: vec4f,
    // The glossy part.
    lobe: Lobe,
    // What lies on both.
    finish: SurfaceFinish,
    // What leaves the surface.
    emission: vec3f,
}

// A place in the picture as one number.
fn pack_place(sample: vec2u) -> u32 {
    return sample.x | (sample.y << 16u);
}

fn unpack_place(place: u32) -> vec2u {
    return vec2u(place & 0xffffu, place >> 16u);
}

// Depth of a sample, 0 where it shows the background.
fn depth_at(sample: vec2u) -> f32 {
    return textureLoad(gbuffer_depth, gbuffer_texel(sample), 0);
}

// Homogeneous point of the world seen through a sample at a depth.
fn unproject(sample: vec2u, depth: f32) -> vec4f {
    return view.world_from_clip * vec4f(ndc_of(sample), depth, 1.0);
}

fn position_at(sample: vec2u, depth: f32) -> vec3f {
    let homogeneous = unproject(sample, depth);
    return homogeneous.xyz / homogeneous.w;
}

// Homogeneous w of a point: its distance along the view, or 1 in a parallel one.
fn w_axis() -> vec4f {
    return vec4f(view.clip_from_world[0].w, view.clip_from_world[1].w, view.clip_from_world[2].w, view.clip_from_world[3].w);
}

// Distance in the world from a sample to the next, across the view, at a point of it.
fn sample_extent_at(position_world: vec3f) -> f32 {
    return view.sample_extent * dot(w_axis(), vec4f(position_world, 1.0));
}

fn normal_at(sample: vec2u) -> vec3f {
    return unpack_normal(textureLoad(gbuffer_geometry, gbuffer_texel(sample), 0).x);
}

fn packed_surface_at(sample: vec2u) -> PackedSurface {
    let texel = gbuffer_texel(sample);
    return unpack_surface(textureLoad(gbuffer_geometry, texel, 0), textureLoad(gbuffer_reflectance, texel, 0));
}

fn base_color_at(sample: vec2u) -> vec3f {
    let packed = packed_surface_at(sample);
    return materials[packed.material].base_color.rgb * packed.base_color;
}

// Albedo of the matte part.
fn diffuse_color_at(sample: vec2u) -> vec3f {
    let packed = packed_surface_at(sample);
    let material = materials[packed.material];
    return material.base_color.rgb * packed.base_color * (1.0 - material.metallic * packed.metallic);
}

// Tint of the interface above a material's matte part (KHR_materials_ior and KHR_materials_specular).
fn interface_tint(material: Material, packed: PackedSurface) -> vec4f {
    let r = (material.ior - 1.0) / (material.ior + 1.0);
    let specular = material.specular * packed.specular;
    return vec4f(min(r * r * material.specular_color * packed.specular_color, vec3f(1.0)) * specular, specular);
}

fn lobe_of(material: Material, packed: PackedSurface) -> Lobe {
    let metal = vec4f(material.base_color.rgb * packed.base_color, 1.0);
    let tint = mix(interface_tint(material, packed), metal, material.metallic * packed.metallic);
    return Lobe(material.model, material.shape * packed.roughness, tint);
}

// What a sample of a depth above 0 shows.
fn surface_at(sample: vec2u, depth: f32) -> Surface {
    let packed = packed_surface_at(sample);
    let material = materials[packed.material];
    var surface: Surface;
    surface.position_world = position_at(sample, depth);
    surface.n = packed.frame.n;
    surface.geometric_normal = packed.geometric_normal;
    surface.wo = normalize(view.eye_world.xyz - surface.position_world * view.eye_world.w);
    surface.frame = packed.frame;
    surface.diffuse_color =
        material.base_color.rgb * packed.base_color * (1.0 - material.metallic * packed.metallic);
    surface.interface_tint = interface_tint(material, packed);
    surface.lobe = lobe_of(material, packed);
    surface.finish = finish_of(material, packed, surface.lobe, local_from_world(surface.frame, surface.wo));
    surface.emission = emitted_through(surface.finish, material.emissive * packed.emission);
    return surface;
}
