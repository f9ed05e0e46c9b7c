#import gbuffer
#import relief_packing

// What the bumps of a material hide from its samples and scatter to them: a second G-buffer, drawn over what the first one shows and only
// where a scene has heights.

@group(GROUP_PASS) @binding(0) var<uniform> relief_map: ReliefMap;
@group(GROUP_PASS) @binding(1) var relief_lit_0: texture_2d<f32>;
@group(GROUP_PASS) @binding(2) var relief_lit_1: texture_2d<f32>;
@group(GROUP_PASS) @binding(3) var relief_scattered: texture_2d<f32>;
@group(GROUP_PASS) @binding(4) var relief_sampler: sampler;

struct ReliefSample {
    @location(0) frame: vec4u,
    @location(1) lit: vec4u,
}

@fragment
fn relief_fragment(surface: Varying) -> ReliefSample {
    let across = dpdx(surface.position_world);
    let down = dpdy(surface.position_world);
    let uvs_across = dpdx(surface.uvs);
    let uvs_down = dpdy(surface.uvs);
    let facet = cross(across, down);
    let to_viewer = view.eye_world.xyz - surface.position_world * view.eye_world.w;
    let n = smooth_normal_of(surface, facet, to_viewer);
    // From behind bumps are dents, of which nothing was prepared.
    let is_front = dot(facet, to_viewer) * dot(facet, n) >= 0.0;
    var packed: PackedRelief;
    let material = materials[surface.material];
    for (var i = material.first_texture; i < material.end_texture; i++) {
        let texture = material_textures[i];
        if texture.kind != TEXTURE_HEIGHT || !is_front {
            continue;
        }
        let uv = texture_uv(texture, surface.uvs);
        let uv_across = texture_uv_change(texture, uvs_across);
        let uv_down = texture_uv_change(texture, uvs_down);
        let gradients = uv_gradients(n, across, down, uv_across, uv_down, 1.0);
        let frame = frame_from_normal(n);
        packed.n = n;
        packed.along_u = relief_map.extent.x * vec2f(dot(gradients.u, frame.t), dot(gradients.u, frame.b));
        packed.along_v = relief_map.extent.y * vec2f(dot(gradients.v, frame.t), dot(gradients.v, frame.b));
        // Texels of a part lie a whole pixel apart, its samples do not.
        let step_across = uv_step(uv_across / f32(view.interleave));
        let step_down = uv_step(uv_down / f32(view.interleave));
        packed.lit_0 = textureSampleGrad(relief_lit_0, relief_sampler, uv, step_across, step_down);
        packed.lit_1 = textureSampleGrad(relief_lit_1, relief_sampler, uv, step_across, step_down);
        packed.scattering = textureSampleGrad(relief_scattered, relief_sampler, uv, step_across, step_down);
    }
    return ReliefSample(pack_relief_frame(packed), pack_relief_lit(packed, relief_map.shape));
}
