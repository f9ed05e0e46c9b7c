#import frame
#import gbuffer_surface
#import light_shading
#import stage_points
#import visibility_bytes

// Takes over what a stencil tells of one light: points within a shadow volume do not see it.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> work: array<u32>;
@group(GROUP_PASS) @binding(2) var<uniform> point_count: u32;
@group(GROUP_PASS) @binding(3) var<storage, read_write> visibilities: array<u32>;
@group(GROUP_PASS) @binding(4) var<uniform> stage: PointStage;
@group(GROUP_PASS) @binding(5) var stencil: texture_2d<u32>;
@group(GROUP_PASS) @binding(6) var<uniform> light: u32;

@compute @workgroup_size(LIGHT_WORKGROUP)
fn take_stencil(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let point = stage_point(workgroup.xy, local);
    if point == NO_POINT {
        return;
    }
    let sample = unpack_place(points[point].sample);
    let surface = surface_of(point);
    var to_light = lights[light].direction;
    if lights[light].kind != KIND_DISTANT {
        to_light = lights[light].position - surface.position_world;
    }
    // What bounds a volume is not behind it: that tells nothing of a surface's other side.
    let is_lit = textureLoad(stencil, gbuffer_texel(sample), 0).x == 0u && dot(surface.geometric_normal, to_light) > 0.0;
    let word = visibility_word(light, point, point_count);
    let shift = 8u * (light % 4u);
    visibilities[word] = (visibilities[word] & ~(255u << shift)) | (select(0u, 255u, is_lit) << shift);
}
