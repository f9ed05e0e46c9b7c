#import frame
#import equirect_texture
#import light_shading
#import sh
#import slot:shadow
#import slot:composite

// Radiance of every sample: all lights with their visibility, the ambient rest, emission, or the environment itself.

@group(1) @binding(0) var gbuffer_depth: texture_depth_2d;
@group(1) @binding(1) var gbuffer_normals: texture_2d<f32>;
@group(1) @binding(2) var gbuffer_base_color_metallic: texture_2d<f32>;
@group(1) @binding(3) var gbuffer_f0_f90: texture_2d<f32>;
@group(1) @binding(4) var gbuffer_emissive_roughness: texture_2d<f32>;

@group(3) @binding(0) var radiance: texture_storage_2d<rgba32float, write>;
// One a sample, where lights come in several batches.
@group(3) @binding(1) var<storage, read_write> light_sums: array<LightSums>;

const FLAG_BACKGROUND: u32 = 1u;
const FLAG_FIRST: u32 = 1u;
const FLAG_LAST: u32 = 2u;
// `gnomon_brdf::MIN_ALPHA`.
const MIN_ALPHA: f32 = 0.002;

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

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let last = (batch.flags & FLAG_LAST) != 0u;
    let ndc = (vec2f(id.xy) + 0.5) / vec2f(view.size) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    let depth = textureLoad(gbuffer_depth, id.xy, 0);
    if depth == 0.0 {
        if !last {
            return;
        }
        let near = view.world_from_clip * vec4f(ndc, 1.0, 1.0);
        let direction = normalize(near.xyz / near.w * view.eye_world.w - view.eye_world.xyz);
        let shown = (view.flags & FLAG_BACKGROUND) != 0u;
        textureStore(radiance, id.xy, vec4f(select(vec3f(0.0), equirect_lookup(background, direction, 0), shown), 0.0));
        return;
    }

    let homogeneous = view.world_from_clip * vec4f(ndc, depth, 1.0);
    let position_world = homogeneous.xyz / homogeneous.w;
    let normals = textureLoad(gbuffer_normals, id.xy, 0);
    let n = octahedral_decode(normals.xy);
    let geometric_normal = octahedral_decode(normals.zw);
    let base_color_metallic = textureLoad(gbuffer_base_color_metallic, id.xy, 0);
    let f0_f90 = textureLoad(gbuffer_f0_f90, id.xy, 0);
    let emissive_roughness = textureLoad(gbuffer_emissive_roughness, id.xy, 0);

    let wo = normalize(view.eye_world.xyz - position_world * view.eye_world.w);
    let metallic = base_color_metallic.a;
    let diffuse_color = base_color_metallic.rgb * (1.0 - metallic);
    let f0 = mix(f0_f90.rgb, base_color_metallic.rgb, metallic);
    let f90 = mix(f0_f90.a, 1.0, metallic);
    let roughness = emissive_roughness.a;
    let alpha = max(roughness * roughness, MIN_ALPHA);
    let n_dot_v = max(dot(n, wo), 1e-4);
    let has_specular = f90 > 0.0;

    let specular_surface = SpecularSurface(n, wo, f0, f90, alpha);
    let sample = id.y * view.size.x + id.x;
    var sums: LightSums;
    if (batch.flags & FLAG_FIRST) == 0u {
        sums = light_sums[sample];
    }
    for (var light = 0u; light < batch.light_count; light++) {
        let form_factor = light_form_factor(light, position_world, n);
        if form_factor <= 0.0 {
            continue;
        }
        let visible = visibility(light, position_world, geometric_normal);
        if lights[light].role == ROLE_PROBE {
            sums.probed += form_factor;
            sums.probed_open += form_factor * visible;
            continue;
        }
        let diffuse = lights[light].radiance * form_factor;
        var specular = vec3f(0.0);
        if has_specular {
            specular = light_specular(light, position_world, specular_surface) * lights[light].radiance;
        }
        if lights[light].kind == KIND_DISTANT {
            sums.diffuse_unshadowed += diffuse;
            sums.diffuse_shadowed += diffuse * visible;
            sums.specular_unshadowed += specular;
            sums.specular_shadowed += specular * visible;
        } else {
            sums.diffuse_near += diffuse * visible;
            sums.specular_near += specular * visible;
        }
    }

    if !last {
        light_sums[sample] = sums;
        return;
    }

    // Of the ambient rest, what the probes see.
    let open = select(1.0, sums.probed_open / sums.probed, sums.probed > 0.0);
    let dfg = environment_brdf(n_dot_v, roughness);
    let specular_albedo = f0 * dfg.x + f90 * dfg.y;
    // What the dielectric's surface lets through to its base, F taken for light along the normal: glTF weighs the base by F at
    // v.h, which stays far from grazing for most light even where n.v does not.
    let base_weight = 1.0 - max_component(f_schlick(f0_f90.rgb, f0_f90.a, sqrt(0.5 + 0.5 * n_dot_v)));
    let ambient_diffuse = max(sh_irradiance(view.residual_sh, n), vec3f(0.0));
    let environment_diffuse = composite(
        equirect_lookup(irradiance_full, n, 0),
        ambient_diffuse + sums.diffuse_unshadowed,
        open * ambient_diffuse + sums.diffuse_shadowed,
    );
    let diffuse = base_weight * (environment_diffuse + sums.diffuse_near);
    var result = emissive_roughness.rgb + diffuse_color / PI * diffuse;
    if has_specular {
        let reflected = reflect(-wo, n);
        let level = roughness * f32(textureNumLevels(prefiltered_full) - 1u);
        let ambient_specular = equirect_lookup_level(prefiltered_residual, reflected, level) * specular_albedo;
        result += composite(
            equirect_lookup_level(prefiltered_full, reflected, level) * specular_albedo,
            ambient_specular + sums.specular_unshadowed,
            open * ambient_specular + sums.specular_shadowed,
        ) + sums.specular_near;
    }
    textureStore(radiance, id.xy, vec4f(result, 1.0));
}
