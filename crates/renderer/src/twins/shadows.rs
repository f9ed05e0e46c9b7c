//! What shadow techniques compute with.

use glam::{Vec2, Vec4};
use gnomon_shaders::twin::{
    depth_moments, micromap, partial_cover, pyramid_meets_box, sample_pattern, series, triangle_hit,
    unit_outline, weighted_box,
};
use gnomon_testing::tolerances::SHADER_TWIN;

use super::compare;

#[test]
fn shadow_series() {
    for group in 0..4 {
        let body = format!("series_phases(a.x, {group}u)[0] + 2.0 * series_phases(a.x, {group}u)[1]");
        compare(
            "series",
            &body,
            SHADER_TWIN,
            |u, _| [u, Vec4::ZERO],
            move |[a, _]| {
                let [cosines, sines] = series::series_phases(a.x, group);
                cosines + 2.0 * sines
            },
        );
    }
    let body = "series_weights(u32(a.x * 4.0), u32(a.y * 17.0))";
    compare(
        "series",
        body,
        1e-6,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| series::series_weights((a.x * 4.0) as u32, (a.y * 17.0) as u32),
    );
    let body = "vec4f(series_lit(mat2x4f(a, b), b, a.wzyx, a), series_blocker_depth(mat2x4f(a, b), b, a.wzyx, a), 0.0, 0.0)";
    compare(
        "series",
        body,
        1e-5,
        |u, v| [u, v],
        |[a, b]| {
            let turned = Vec4::new(a.w, a.z, a.y, a.x);
            let lit = series::series_lit([a, b], b, turned, a);
            Vec4::new(lit, series::series_blocker_depth([a, b], b, turned, a), 0.0, 0.0)
        },
    );
    let body = "vec4f(suppress_ringing(a.x * 1.4 - 0.2, 0.05, 0.9), sharpen(a.y, a.z, 30.0, 10.0), level_from_width(a.w * 500.0), 0.0)";
    // Just below a power of two the floor of the logarithm may fall either way; the level is continuous there.
    compare(
        "series",
        body,
        SHADER_TWIN,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| {
            Vec4::new(
                series::suppress_ringing(a.x * 1.4 - 0.2, 0.05, 0.9),
                series::sharpen(a.y, a.z, 30.0, 10.0),
                series::level_from_width(a.w * 500.0),
                0.0,
            )
        },
    );
}

#[test]
fn sample_patterns() {
    let body = "vec4f(vogel_disk(u32(a.x * 64.0), u32(a.y * 64.0) + 1u, a.z), hammersley(u32(a.x * 64.0), u32(a.y * 64.0) + 1u))";
    compare(
        "sample_pattern",
        body,
        SHADER_TWIN,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| {
            let (i, count) = ((a.x * 64.0) as u32, (a.y * 64.0) as u32 + 1);
            let (disk, square) =
                (sample_pattern::vogel_disk(i, count, a.z), sample_pattern::hammersley(i, count));
            disk.extend(square.x).extend(square.y)
        },
    );
}

#[test]
fn weighted_boxes() {
    let input = |u: Vec4, v: Vec4| [(2.0 * u - 1.0).with_w(0.0), (0.01 + v).with_z(0.0).with_w(0.0)];
    let body = "vec4f(weighted_box(a.xyz, b.xy).center, weighted_box(a.xyz, b.xy).half_extent)";
    compare("weighted_box", body, 1e-3, input, |[a, b]| {
        let found = weighted_box::weighted_box(a.truncate(), Vec2::new(b.x, b.y));
        found.center.extend(found.half_extent.x).extend(found.half_extent.y)
    });
}

#[test]
fn outlines_as_units() {
    // Half sides that are far from parallel, either way round.
    let input = |u: Vec4, v: Vec4| {
        let turned = if v.w > 0.5 { -1.0 } else { 1.0 };
        [u - 0.5, Vec4::new(0.3 + v.x, 0.2 * v.y, 0.2 * v.z, turned * (0.3 + v.w))]
    };
    let body = "vec4f(reach_in_outline(unit_parallelogram(a.xy, b.xy, b.zw), a.zw, 0.7), unit_parallelogram(a.xy, b.xy, b.zw).growth, reach_in_outline(unit_disk(b.x), a.zw, 0.7), unit_disk(b.x).growth)";
    compare("unit_outline", body, 1e-4, input, |[a, b]| {
        let (middle, place) = (Vec2::new(a.x, a.y), Vec2::new(a.z, a.w));
        let quad = unit_outline::unit_parallelogram(middle, Vec2::new(b.x, b.y), Vec2::new(b.z, b.w));
        let disk = unit_outline::unit_disk(b.x);
        let reach = |unit| unit_outline::reach_in_outline(unit, place, 0.7);
        Vec4::new(reach(&quad), quad.growth, reach(&disk), disk.growth)
    });
}

#[test]
fn moments_of_depth() {
    // Four depths far enough apart for well-conditioned moments, the receiver's among them.
    let input = |u: Vec4, v: Vec4| {
        let z = Vec4::new(-0.9, -0.4, 0.1, 0.6) + 0.3 * u;
        let receiver = Vec4::new(2.0 * v.x - 1.0, 0.1 + v.y, 0.1 + v.z, 0.1 + v.w);
        [z, receiver]
    };
    let weights = "vec4f(b.yzw, 0.5) / (b.y + b.z + b.w + 0.5)";
    let columns = "depth_moments(a.x), depth_moments(a.y), depth_moments(a.z), depth_moments(a.w)";
    let moments = format!("biased_moments(mat4x4f({columns}) * ({weights}), 1e-4)");
    let twin = |[a, b]: [Vec4; 2]| {
        let weights = Vec4::new(b.y, b.z, b.w, 0.5) / (b.y + b.z + b.w + 0.5);
        let moments = (0..4).map(|i| weights[i] * depth_moments::depth_moments(a[i])).sum();
        depth_moments::biased_moments(moments, 1e-4)
    };
    compare("depth_moments", &moments, 1e-6, input, twin);
    // The matrix of moments amplifies rounding by its condition, some 1e3.
    let atoms = format!("three_atoms({moments}, b.x)");
    let body = format!(
        "vec4f({atoms}.weights.x, blockers_in_front({atoms}) * vec2f(1.0, blockers_in_front({atoms}).x), 0.0)"
    );
    compare("depth_moments", &body, 2e-3, input, |[a, b]| {
        let atoms = depth_moments::three_atoms(twin([a, b]), b.x);
        let found = depth_moments::blockers_in_front(atoms);
        // Where next to nothing is in front, its depth means nothing.
        Vec4::new(atoms.weights.x, found.x, found.x * found.y, 0.0)
    });
}

#[test]
fn rays_and_triangles() {
    // Corners about a direction, so that every other ray hits.
    let input = |u: Vec4, v: Vec4| [(u - 0.5).with_w(v.w), (v - 0.5).with_w(u.w)];
    let corners = "vec3f(a.x, a.y, 1.0 + a.w), vec3f(a.z, b.x, 1.0 + b.w), vec3f(b.y, b.z, 1.5)";
    let body = format!("triangle_hit({corners}, vec3f(0.02, 0.03, 1.0))");
    compare("triangle_hit", &body, 1e-3, input, |[a, b]| {
        let corners = [[a.x, a.y, 1.0 + a.w], [a.z, b.x, 1.0 + b.w], [b.y, b.z, 1.5]].map(glam::Vec3::from);
        let hit =
            triangle_hit::triangle_hit(corners[0], corners[1], corners[2], glam::Vec3::new(0.02, 0.03, 1.0));
        // Slivers amplify rounding.
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).z.abs();
        if area > 1e-3 { hit } else { hit.round() }
    });
    // Pyramids about +z, boxes before them and beside them; turned, so that each axis is the one along which no ray goes back, and mirrored.
    let input = |u: Vec4, v: Vec4| [(u - 0.5).with_z(u.z), (v - 0.5).with_z(v.z)];
    let places = [
        "vec3f(a.xy - 0.3, 0.9)",
        "vec3f(a.xy + 0.2, 1.1)",
        "vec3f(b.xy, a.z)",
        "vec3f(b.xy + 0.3, a.z + b.z)",
    ];
    for (order, sign) in
        [("xyz", 1.0), ("zxy", 1.0), ("yzx", 1.0), ("xyz", -1.0), ("zxy", -1.0), ("yzx", -1.0)]
    {
        let [least, most, low, high] = places.map(|place| format!("{sign:?} * {place}.{order}"));
        // What was least is most in a mirror.
        let [least, most, low, high] =
            if sign > 0.0 { [least, most, low, high] } else { [most, least, high, low] };
        let body = format!(
            "vec4f(select(0.0, 1.0, pyramid_meets_box({least}, {most}, {low}, {high}, 0.8)), vec3f(0.0))"
        );
        compare("pyramid_meets_box", &body, 0.0, input, |[a, b]| {
            let vector = |x: f32, y: f32, z: f32| {
                sign * match order {
                    "xyz" => glam::Vec3::new(x, y, z),
                    "zxy" => glam::Vec3::new(z, x, y),
                    _ => glam::Vec3::new(y, z, x),
                }
            };
            let least = vector(a.x - 0.3, a.y - 0.3, 0.9);
            let most = vector(a.x + 0.2, a.y + 0.2, 1.1);
            let low = vector(b.x, b.y, a.z);
            let high = vector(b.x + 0.3, b.y + 0.3, a.z + b.z);
            let meets = match sign > 0.0 {
                true => pyramid_meets_box::pyramid_meets_box(least, most, low, high, 0.8),
                false => pyramid_meets_box::pyramid_meets_box(most, least, high, low, 0.8),
            };
            Vec4::new(f32::from(meets), 0.0, 0.0, 0.0)
        });
    }
    let body = "vec4f(f32(micro_triangle(a.x, a.y, u32(a.z * 64.0) + 1u)), 0.0, 0.0, 0.0)";
    compare(
        "micromap",
        body,
        0.0,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| {
            let number = micromap::micro_triangle(a.x, a.y, (a.z * 64.0) as u32 + 1);
            Vec4::new(number as f32, 0.0, 0.0, 0.0)
        },
    );
}

#[test]
fn surfaces_in_part_of_the_texels() {
    let body = "vec4f(f32(is_covered(a.x, vec2u(b.xy * 9000.0), cover_key(u32(a.y * 256.0), u32(a.z * 9.0), a.w < 0.5))), 0.0, 0.0, 0.0)";
    compare(
        "partial_cover",
        body,
        0.0,
        |u, v| [u, v],
        |[a, b]| {
            let texel = glam::UVec2::new((b.x * 9000.0) as u32, (b.y * 9000.0) as u32);
            let key = partial_cover::cover_key((a.y * 256.0) as u32, (a.z * 9.0) as u32, a.w < 0.5);
            Vec4::new(f32::from(u8::from(partial_cover::is_covered(a.x, texel, key))), 0.0, 0.0, 0.0)
        },
    );
}
