#import gbuffer_surface
#import resample
#import packed_sums

// Sums of light at any sample from those at shading points (DeCoro and Rusinkiewicz 2008, section 3.2). The importer binds
// `points: array<ShadingPoint>` and `point_of_tile: array<u32>`, and the sums.

// Weights that make no difference.
const NEGLIGIBLE_WEIGHT: f32 = 1e-3;
// A tile's point has less weight than this for samples that it says nothing about.
const NEIGHBOUR_MIN_WEIGHT: f32 = 0.05;

// Exponent of n . n' for a sample that shows a surface.
fn normal_power_at(sample: vec2u) -> f32 {
    if (view.flags & FLAG_SPECULAR_SUMS) == 0u {
        return resample_normal_power(1.0);
    }
    let packed = packed_surface_at(sample);
    let material = materials[packed.material];
    return resample_normal_power(sharpest_alpha_of(material, packed, lobe_of(material, packed)));
}

// Weight of a shading point of a list for a sample of the picture.
fn point_weight(list: u32, point: ShadingPoint, sample: vec2u, position_world: vec3f, n: vec3f, normal_power: f32) -> f32 {
    return wide_point_weight(list, point, sample, position_world, n, normal_power, 1.0);
}

// The same, `widening` times as wide across the screen.
fn wide_point_weight(
    list: u32,
    point: ShadingPoint,
    sample: vec2u,
    position_world: vec3f,
    n: vec3f,
    normal_power: f32,
    widening: f32,
) -> f32 {
    let side = f32(view.point_lists[list].sampling);
    let place = sample_place(unpack_place(point.sample));
    let position = vec3f(point.position_world[0], point.position_world[1], point.position_world[2]);
    let normal = octahedral_decode(unpack2x16float(point.normal));
    let height = dot(n, position - position_world) / (side * sample_extent_at(position_world));
    return resample_weight((place - sample_place(sample)) / (side * widening), height, dot(n, normal), normal_power);
}

// Number of the point of the `i`-th of the nine tiles around a sample, row by row, the fifth its own.
fn neighbour_point(list: u32, sample: vec2u, i: i32) -> u32 {
    let side = view.point_lists[list].sampling;
    let shift = vec2u(firstTrailingBit(side));
    let tiles = vec2i((view.size + side - 1u) >> shift);
    let tile = vec2i(sample >> shift) + vec2i(i % 3, i / 3) - 1;
    if any(tile < vec2i(0)) || any(tile >= tiles) {
        return NO_POINT;
    }
    return point_of_tile[view.point_lists[list].first_tile + u32(tile.y * tiles.x + tile.x)];
}

// Sums by few rays are grainy, each tile's another way than those beside it: a wider mean takes most of that out. Not where there are highlights,
// which it would blur.
const GRAINY_WIDENING: f32 = 1.4;

// The mean of the sums of the tiles around a sample.
fn gathered_sums(list: u32, sample: vec2u, position_world: vec3f, n: vec3f) -> LightSums {
    var sums: LightSums;
    if view.point_lists[list].sampling == 1u {
        let point = neighbour_point(list, sample, 4);
        if point != NO_POINT {
            sums = load_sums(point);
        }
        return sums;
    }
    let normal_power = normal_power_at(sample);
    let widening_flags = view.flags & (FLAG_GRAINY_SUMS | FLAG_EVENED_SUMS | FLAG_SPECULAR_SUMS);
    let widening = select(1.0, GRAINY_WIDENING, widening_flags == FLAG_GRAINY_SUMS);
    var weights = 0.0;
    var last = NO_POINT;
    for (var i = 0; i < 9; i++) {
        let point = neighbour_point(list, sample, i);
        if point != NO_POINT {
            let weight = wide_point_weight(list, points[point], sample, position_world, n, normal_power, widening);
            if weight > NEGLIGIBLE_WEIGHT {
                add_weighted(&sums, weight, load_sums(point));
                weights += weight;
            }
            last = point;
        }
    }
    if weights == 0.0 {
        // Only where the list had no room for a point of its own.
        var nearest: LightSums;
        if last != NO_POINT {
            nearest = load_sums(last);
        }
        return nearest;
    }
    var mean: LightSums;
    add_weighted(&mean, 1.0 / weights, sums);
    return mean;
}
