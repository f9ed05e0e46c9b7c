#import gbuffer_surface
#import hit_normals
#import ray_scene
#import wrapped

// What a ray meets, as it is seen in a reflection: base colours have few texels, of all else that textures say there is the mean.

// Two texels a triangle: material and HIT_SHINES, colour of its vertices, and texture coordinates of its corners.
@group(GROUP_SHADOW) @binding(3) var hit_triangles: texture_2d<u32>;
// Texels of a material, see `far_materials.rs`.
@group(GROUP_SHADOW) @binding(4) var far_materials: texture_2d<f32>;
@group(GROUP_SHADOW) @binding(5) var far_colors: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(6) var far_sampler: sampler;

fn far_material(material: u32, texel: u32) -> vec4f {
    let place = vec2u((material % FAR_MATERIALS_A_ROW) * FAR_MATERIAL_TEXELS + texel, material / FAR_MATERIALS_A_ROW);
    return textureLoad(far_materials, place, 0);
}

// The surface of a hit on a ray along `direction`, a unit vector.
fn surface_of_hit(hit: RayHit, direction: vec3f) -> Surface {
    var corners = ray_corners(hit.triangle);
    if hit.copy != 0u {
        corners = mat3x3f(
            through_rows(hit.copy + 3u, vec4f(corners[0], 1.0)),
            through_rows(hit.copy + 3u, vec4f(corners[1], 1.0)),
            through_rows(hit.copy + 3u, vec4f(corners[2], 1.0)),
        );
    }
    let share = vec3f(1.0 - hit.v - hit.w, hit.v, hit.w);
    var surface: Surface;
    surface.position_world = corners * share;
    surface.wo = -direction;
    let facet = normalize(cross(corners[1] - corners[0], corners[2] - corners[0]));
    surface.geometric_normal = facet * select(-1.0, 1.0, dot(facet, direction) <= 0.0);
    let normals = ray_normals(hit.triangle);
    var smooth_normal = unpack_third(normals, 0u) * share.x + unpack_third(normals, 1u) * share.y + unpack_third(normals, 2u) * share.z;
    if hit.copy != 0u {
        smooth_normal = normal_of_copy(hit.copy, smooth_normal);
    }
    let is_smooth = dot(smooth_normal, smooth_normal) > 1e-8;
    let n = select(surface.geometric_normal, normalize(smooth_normal), is_smooth);
    surface.n = n * select(-1.0, 1.0, dot(n, surface.geometric_normal) >= 0.0);
    surface.frame = frame_from_normal(surface.n);

    let place = vec2u(2u * (hit.triangle % HIT_TRIANGLES_A_ROW), hit.triangle / HIT_TRIANGLES_A_ROW);
    let first = textureLoad(hit_triangles, place, 0);
    let second = textureLoad(hit_triangles, place + vec2u(1u, 0u), 0);
    let uv = bitcast<vec2f>(first.zw) * share.x + bitcast<vec2f>(second.xy) * share.y + bitcast<vec2f>(second.zw) * share.z;
    let number = first.x & ~HIT_SHINES;
    let material = materials[number];
    let rows = array(far_material(number, 0u), far_material(number, 1u));
    let means = far_material(number, 2u);
    var packed: PackedSurface;
    packed.base_color = unpack_rgb9e5(first.y) * far_material(number, 4u).rgb;
    // Lobes reflect the lights that stand for emission.
    packed.emission = select(far_material(number, 3u).rgb, vec3f(0.0), (first.x & HIT_SHINES) != 0u);
    packed.specular_color = vec3f(1.0);
    packed.specular = means.z;
    packed.roughness = material.roughness * means.y;
    packed.metallic = means.x;
    packed.finish = select(pack_coat(1.0, 1.0, vec2f(0.0)), pack_sheen(vec3f(1.0), 1.0), material.has_sheen_textures != 0u);
    if rows[0].w > 0.0 {
        let texel = vec2f(dot(rows[0].xy, uv) + rows[0].z, dot(rows[1].xy, uv) + rows[1].z);
        let wrap = u32(rows[1].w);
        let wrapped = vec2f(wrapped_coordinate(texel.x, wrap % 4u), wrapped_coordinate(texel.y, wrap / 4u));
        packed.base_color =
            unpack_rgb9e5(first.y) * textureSampleLevel(far_colors, far_sampler, wrapped, u32(rows[0].w) - 1u, 0.0).rgb;
    }
    surface.diffuse_color =
        material.base_color.rgb * packed.base_color * (1.0 - material.metallic * packed.metallic);
    surface.interface_tint = interface_tint(material, packed);
    surface.lobe = lobe_of(material, packed);
    surface.finish = finish_of(material, packed, surface.lobe, local_from_world(surface.frame, surface.wo));
    surface.emission = emitted_through(surface.finish, material.emissive * packed.emission);
    return surface;
}

// Where rays from a hit begin that lies so far along its own ray [m].
fn origin_of_hit(surface: Surface, distance: f32) -> vec3f {
    let place = abs(surface.position_world);
    return surface.position_world + surface.geometric_normal * (HIT_ROUNDING * (max_component(place) + distance));
}

// Rounding of a place that was found from a triangle's corners, as a share of its coordinates.
const HIT_ROUNDING: f32 = 4e-6;
