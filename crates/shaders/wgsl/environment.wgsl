#import view
#import equirect_texture
#import prefiltered

// The frame of the pass that makes a picture of the sums: the environment.

// The whole environment as the camera sees it, in units of view.background_factor. All other maps are in those of
// view.environment_factor.
@group(GROUP_FRAME) @binding(1) var background: texture_2d<f32>;
// Irradiance over the sphere of normals of all but the emitters.
@group(GROUP_FRAME) @binding(2) var irradiance_rest: texture_2d<f32>;
// GGX-prefiltered radiance, levels as in prefiltered.wgsl: whole environment, residual.
@group(GROUP_FRAME) @binding(3) var prefiltered_full: texture_2d<f32>;
@group(GROUP_FRAME) @binding(4) var prefiltered_residual: texture_2d<f32>;
// Scale and bias of f0 in the environment BRDF (Karis 2013) over (n.v, roughness).
@group(GROUP_FRAME) @binding(5) var dfg_table: texture_2d<f32>;

// Small bright parts of the environment, in its own frame.
@group(GROUP_FRAME) @binding(9) var<uniform> emitters: Emitters;

// The whole environment with mip levels.
@group(GROUP_FRAME) @binding(10) var environment_levels: texture_2d<f32>;

// A direction of the world in the frame that the maps and coefficients are in.
fn environment_direction(direction_world: vec3f) -> vec3f {
    return (view.environment_from_world * vec4f(direction_world, 0.0)).xyz;
}

fn environment_brdf(n_dot_v: f32, roughness: f32) -> vec2f {
    let size = vec2f(textureDimensions(dfg_table));
    let position = saturate(vec2f(n_dot_v, roughness)) * (size - 1.0);
    let low = vec2i(position);
    let high = min(low + 1, vec2i(size) - 1);
    let t = position - vec2f(low);
    let near = mix(textureLoad(dfg_table, low, 0).rg, textureLoad(dfg_table, vec2i(high.x, low.y), 0).rg, t.x);
    let far = mix(textureLoad(dfg_table, vec2i(low.x, high.y), 0).rg, textureLoad(dfg_table, high, 0).rg, t.x);
    return mix(near, far, t.y);
}
