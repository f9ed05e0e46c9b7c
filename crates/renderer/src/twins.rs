//! Shader functions against their Rust twins over random inputs, on whatever adapter there is.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};
use gnomon_envmap::{Equirect, Sh9};
use gnomon_lights::{DistantLight, LightShape};
use gnomon_shaders::twin::{
    depth_moments, half_pairs, hemisphere, math, resample, sample_pattern, series, weighted_box,
};
use gnomon_testing::tolerances::SHADER_TWIN;

use crate::bindings::Binding;
use crate::gpu::ReadBack;
use crate::{Gpu, GpuOptions};

mod gbuffer_packing;
mod reflectance;

const COUNT: usize = 4096;

/// An adapter, or `None` after printing why the test is skipped.
pub(crate) fn gpu_or_skip() -> Option<Gpu> {
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            gnomon_testing::skip(&error.to_string());
            None
        }
    }
}

/// Four numbers in [0, 1) for every call, by an additive recurrence of low discrepancy (Roberts 2018, R4).
fn uniform(i: usize) -> Vec4 {
    let steps = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_3_f64];
    Vec4::from_array(steps.map(|step| ((i as f64 + 1.0) * step).fract() as f32))
}

fn unit_vector(u: Vec4) -> Vec3 {
    Equirect::direction_from_uv(Vec2::new(u.x, (1.0 - 2.0 * u.y).acos() / std::f32::consts::PI))
}

/// Runs `body` on the GPU, an expression of type vec4f of two inputs `a` and `b`, over `inputs`.
fn evaluate(gpu: &Gpu, module: &str, body: &str, inputs: &[[Vec4; 2]]) -> Vec<Vec4> {
    let source = format!(
        "{}
        @group(0) @binding(0) var<storage, read> twin_inputs: array<array<vec4f, 2>>;
        @group(0) @binding(1) var<storage, read_write> twin_outputs: array<vec4f>;
        @compute @workgroup_size(64)
        fn twin(@builtin(global_invocation_id) id: vec3u) {{
            if id.x >= arrayLength(&twin_inputs) {{ return; }}
            let a = twin_inputs[id.x][0];
            let b = twin_inputs[id.x][1];
            twin_outputs[id.x] = {body};
        }}",
        gnomon_shaders::resolve(module, &[]).unwrap()
    );
    let shader = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("twin"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let bindings = [(0, Binding::Storage { read_only: true }), (1, Binding::Storage { read_only: false })];
    let layout = gpu.layout("twin", wgpu::ShaderStages::COMPUTE, &bindings);
    let pipeline = gpu.new_compute_pipeline(&shader, "twin", &[(0, &layout)]);
    let input = gpu.buffer_with("inputs", bytemuck::cast_slice(inputs), wgpu::BufferUsages::STORAGE);
    let size = 16 * inputs.len() as u64;
    let output =
        gpu.empty_buffer("outputs", size, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let mapped =
        gpu.empty_buffer("mapped", size, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group =
        gpu.bind_group("twin", &layout, &[(0, input.as_entire_binding()), (1, output.as_entire_binding())]);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(inputs.len().div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &mapped, 0, size);
    let read_back = ReadBack::of_buffer(gpu, &encoder, mapped);
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.wait_for(read_back).unwrap();
    bytemuck::pod_collect_to_vec::<u8, Vec4>(&bytes)[..inputs.len()].to_vec()
}

/// Largest difference between shader and twin, each relative to the value where that exceeds 1.
fn worst(shader: &[Vec4], inputs: &[[Vec4; 2]], twin: impl Fn([Vec4; 2]) -> Vec4) -> f32 {
    let difference = |(got, input): (&Vec4, &[Vec4; 2])| {
        let want = twin(*input);
        assert!(got.is_finite() && want.is_finite(), "{input:?}: shader {got}, twin {want}");
        ((*got - want).abs() / want.abs().max(Vec4::ONE)).max_element()
    };
    shader.iter().zip(inputs).map(difference).fold(0.0, f32::max)
}

/// Compares one function over inputs made from uniform numbers.
fn compare(
    module: &str,
    body: &str,
    tolerance: f32,
    input: impl Fn(Vec4, Vec4) -> [Vec4; 2],
    twin: impl Fn([Vec4; 2]) -> Vec4,
) {
    let Some(gpu) = gpu_or_skip() else { return };
    let inputs: Vec<_> = (0..COUNT).map(|i| input(uniform(i), uniform(i + 3 * COUNT))).collect();
    let shader = evaluate(&gpu, module, body, &inputs);
    assert_eq!(shader.len(), COUNT);
    let worst = worst(&shader, &inputs, twin);
    assert!(worst <= tolerance, "{body}: differs by {worst}, more than {tolerance}");
}

fn scalar(value: f32) -> Vec4 {
    Vec4::new(value, 0.0, 0.0, 0.0)
}

#[test]
fn octahedral_maps() {
    let input = |u, _| [unit_vector(u).extend(0.0), Vec4::ZERO];
    compare("math", "vec4f(octahedral_encode(a.xyz), 0.0, 0.0)", 1e-5, input, |[a, _]| {
        math::octahedral_encode(a.truncate()).extend(0.0).extend(0.0)
    });
    compare("math", "vec4f(octahedral_decode(octahedral_encode(a.xyz)), 0.0)", 1e-5, input, |[a, _]| a);
}

#[test]
fn luminance() {
    compare(
        "math",
        "vec4f(luminance(a.xyz))",
        1e-6,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| Vec4::splat(a.truncate().dot(gnomon_picture::LUMINANCE)),
    );
}

#[test]
fn equirect_mapping() {
    let away_from_the_seam =
        |u: Vec4, _| [Vec4::new(0.01 + 0.98 * u.x, 0.01 + 0.98 * u.y, 0.0, 0.0), Vec4::ZERO];
    compare("math", "vec4f(direction_from_uv(a.xy), 0.0)", 1e-5, away_from_the_seam, |[a, _]| {
        Equirect::direction_from_uv(Vec2::new(a.x, a.y)).extend(0.0)
    });
    compare(
        "math",
        "vec4f(uv_from_direction(direction_from_uv(a.xy)), 0.0, 0.0)",
        SHADER_TWIN,
        away_from_the_seam,
        |[a, _]| {
            let uv = Equirect::uv_from_direction(Equirect::direction_from_uv(Vec2::new(a.x, a.y)));
            uv.extend(0.0).extend(0.0)
        },
    );
}

#[test]
fn hemisphere_maps() {
    let above = |u, _| {
        let n = unit_vector(u);
        [Vec4::new(n.x, n.y, n.z.abs(), 0.0), Vec4::ZERO]
    };
    compare("hemisphere", "vec4f(hemisphere_encode(a.xyz), 0.0, 0.0)", 1e-5, above, |[a, _]| {
        hemisphere::hemisphere_encode(a.truncate()).extend(0.0).extend(0.0)
    });
    compare("hemisphere", "vec4f(hemisphere_decode(hemisphere_encode(a.xyz)), 0.0)", 1e-5, above, |[a, _]| a);
    compare(
        "hemisphere",
        "vec4f(hemisphere_decode(2.0 * a.xy - 1.0), 0.0)",
        1e-5,
        |u, _| [u, Vec4::ZERO],
        |[a, _]| hemisphere::hemisphere_decode(2.0 * Vec2::new(a.x, a.y) - 1.0).extend(0.0),
    );
}

#[test]
fn prefiltered_levels() {
    let input = |u: Vec4, _| [Vec4::new(u.x * u.x * u.x, 1.0 + (7.0 * u.y).floor(), 0.0, 0.0), Vec4::ZERO];
    compare(
        "prefiltered",
        "vec4f(prefiltered_level(a.x, a.y), 0.0, 0.0, 0.0)",
        SHADER_TWIN,
        input,
        |[a, _]| scalar(gnomon_envmap::prefiltered_level(a.x, a.y)),
    );
}

#[test]
fn resampling() {
    let input = |u: Vec4, _| {
        let alpha = 0.05 + 0.95 * u.x;
        [Vec4::new(3.0 * u.x - 1.5, 3.0 * u.y - 1.5, 2.0 * u.z - 1.0, 2.0 * u.w - 1.0), Vec4::splat(alpha)]
    };
    let expression = "vec4f(resample_weight(a.xy, a.z, a.w, resample_normal_power(b.x)), 0.0, 0.0, 0.0)";
    compare("resample", expression, 1e-5, input, |[a, b]| {
        let normal_power = resample::resample_normal_power(b.x);
        scalar(resample::resample_weight(Vec2::new(a.x, a.y), a.z, a.w, normal_power))
    });
}

#[test]
fn ggx() {
    let input = |u: Vec4, _| [Vec4::new(u.x, u.y.max(0.01), 0.05 + 0.95 * u.z, u.w), Vec4::ZERO];
    compare("brdf_ggx", "vec4f(d_ggx(a.x, a.z), 0.0, 0.0, 0.0)", 2e-3, input, |[a, _]| {
        scalar(gnomon_brdf::d_ggx(a.x, a.z))
    });
    let input =
        |u: Vec4, _| [Vec4::new(0.02 + 0.98 * u.x, 0.02 + 0.98 * u.y, 0.05 + 0.95 * u.z, u.w), Vec4::ZERO];
    compare(
        "brdf_ggx",
        "vec4f(v_smith_ggx_correlated(a.x, a.y, a.z), 0.0, 0.0, 0.0)",
        SHADER_TWIN,
        input,
        |[a, _]| scalar(gnomon_brdf::v_smith_ggx_correlated(a.x, a.y, a.z)),
    );
    compare(
        "brdf_lobe",
        "vec4f(f_schlick(a.xyz, a.w, b.x), 0.0)",
        1e-5,
        |u, v| [u, v],
        |[a, b]| gnomon_brdf::f_schlick(a.truncate(), a.w, b.x).extend(0.0),
    );
}

#[test]
fn form_factors() {
    let input = |u: Vec4, v: Vec4| [unit_vector(u).extend(0.01 + 1.4 * u.z), unit_vector(v).extend(0.0)];
    compare(
        "form_factor",
        "vec4f(disk_form_factor(b.xyz, a.xyz, a.w), 0.0, 0.0, 0.0)",
        2e-4,
        input,
        |[a, b]| scalar(gnomon_lights::form_factor::disk_form_factor(b.truncate(), a.truncate(), a.w)),
    );
    // A rectangle on the plane z = 1, counter-clockwise seen from the origin.
    let corners = |u: Vec4| {
        let min = Vec2::new(u.x, u.y) * 1.6 - 1.0;
        let max = min + Vec2::new(u.z, u.w) * 0.35 + 0.05;
        [min, Vec2::new(min.x, max.y), max, Vec2::new(max.x, min.y)].map(|p| p.extend(1.0).normalize())
    };
    let corner = |x: &str, y: &str| format!("vec4f(normalize(vec3f({x}, {y}, 1.0)), 0.0)");
    let (x0, y0) = ("a.x * 1.6 - 1.0", "a.y * 1.6 - 1.0");
    let (x1, y1) = ("a.x * 1.6 - 1.0 + a.z * 0.35 + 0.05", "a.y * 1.6 - 1.0 + a.w * 0.35 + 0.05");
    let list = [corner(x0, y0), corner(x0, y1), corner(x1, y1), corner(x1, y0)].join(", ");
    let body = format!("vec4f(rectangle_form_factor(b.xyz, array<vec4f, 4>({list})), 0.0, 0.0, 0.0)");
    compare(
        "form_factor",
        &body,
        2e-4,
        |u, v| [u, unit_vector(v).extend(0.0)],
        |[a, b]| scalar(gnomon_lights::form_factor::rectangle_form_factor(b.truncate(), corners(a))),
    );
}

#[test]
fn flat_disk_form_factors() {
    // Across, above and below the horizon; from close by to five radii away.
    let center = "vec3f(a.x * 2.0 - 1.0, a.y * 2.0 - 1.0, a.z * 2.0 + 0.05)";
    let body = format!(
        "vec4f(flat_disk_form_factor(b.xyz, {center}, vec3f(0.4, 0.0, 0.0), vec3f(0.0, 0.4 * (0.2 + a.w), 0.0)), 0.0, 0.0, 0.0)"
    );
    compare(
        "form_factor",
        &body,
        2e-4,
        |u, v| [u, unit_vector(v).extend(0.0)],
        |[a, b]| {
            let center = Vec3::new(a.x * 2.0 - 1.0, a.y * 2.0 - 1.0, a.z * 2.0 + 0.05);
            let axes = [Vec3::new(0.4, 0.0, 0.0), Vec3::new(0.0, 0.4 * (0.2 + a.w), 0.0)];
            scalar(gnomon_lights::form_factor::flat_disk_form_factor(b.truncate(), center, axes[0], axes[1]))
        },
    );
}

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
fn irradiance_of_spherical_harmonics() {
    let coefficients: [Vec3; 9] = std::array::from_fn(|i| uniform(i).truncate() - 0.5);
    let list = coefficients.map(|c| format!("vec4f({:?}, {:?}, {:?}, 0.0)", c.x, c.y, c.z)).join(", ");
    let body = format!("vec4f(sh_irradiance(array<vec4f, 9>({list}), a.xyz), 0.0)");
    compare(
        "sh",
        &body,
        1e-5,
        |u, _| [unit_vector(u).extend(0.0), Vec4::ZERO],
        |[a, _]| Sh9 { coefficients }.irradiance(a.truncate()).extend(0.0),
    );
}

#[test]
fn tone_mapping() {
    let bright = |u: Vec4, _| [8.0 * u * u, Vec4::ZERO];
    let unit = |u, _| [u, Vec4::ZERO];
    compare("tonemap", "vec4f(srgb_decode(a.x))", SHADER_TWIN, unit, |[a, _]| {
        Vec4::splat(gnomon_picture::tonemap::srgb_decode(a.x))
    });
    compare(
        "tonemap",
        "vec4f(tone_map_neutral(a.xyz), srgb_encode(a.w / 8.0))",
        SHADER_TWIN,
        bright,
        |[a, _]| {
            let mapped = gnomon_picture::tonemap::tone_map_neutral(a.truncate());
            mapped.extend(gnomon_picture::tonemap::srgb_encode(a.w / 8.0))
        },
    );
}

#[test]
fn angles_to_outlines() {
    let direction = |u: Vec4, v| [unit_vector(u).extend(0.01 + u.w), unit_vector(v).extend(0.0)];
    compare(
        "outline_angle",
        "vec4f(disk_signed_angle(b.xyz, a.xyz, a.w))",
        SHADER_TWIN,
        direction,
        |[a, b]| {
            let light = DistantLight::disk(a.truncate().as_dvec3(), f64::from(a.w), DVec3::ONE);
            Vec4::splat(light.signed_angle(b.truncate()))
        },
    );
    let front = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
    let light = DistantLight::rectangle(front, DVec2::new(-0.6, 0.1), DVec2::new(0.4, 0.9), DVec3::ONE);
    let LightShape::Rectangle { corners } = light.shape else { panic!("not a rectangle") };
    let corners = corners.map(|c| format!("vec4f({}, {}, {}, 0.0)", c.x, c.y, c.z)).join(", ");
    // Drivers approximate asin.
    let body = format!("vec4f(rectangle_signed_angle(a.xyz, array({corners})))");
    compare(
        "outline_angle",
        &body,
        5e-4,
        |u, _| [unit_vector(u).extend(0.0), Vec4::ZERO],
        |[a, _]| Vec4::splat(light.signed_angle(a.truncate())),
    );
}

#[test]
fn a_planted_fault_is_found() {
    let Some(gpu) = gpu_or_skip() else { return };
    let inputs: Vec<_> = (0..COUNT).map(|i| [uniform(i), Vec4::ZERO]).collect();
    let shader = evaluate(&gpu, "brdf_ggx", "vec4f(d_ggx(a.x, a.y + 0.1), 0.0, 0.0, 0.0)", &inputs);
    let faulty = worst(&shader, &inputs, |[a, _]| scalar(gnomon_brdf::d_ggx(a.x, a.y + 0.101)));
    let sound = worst(&shader, &inputs, |[a, _]| scalar(gnomon_brdf::d_ggx(a.x, a.y + 0.1)));
    assert!(faulty > 2e-3 && sound < 2e-3, "faulty {faulty}, sound {sound}");
}

#[test]
fn colors_in_halves() {
    // Over all magnitudes that halves have, and beyond the largest.
    let scaled = |u: Vec4, exponent: f32| u * (40.0 * exponent - 22.0).exp2();
    let input = |u: Vec4, v: Vec4| [scaled(u, v.w), scaled(v, u.w)];
    let pair = "unpack_color_pair(pack_color_pair(a.xyz, b.xyz))";
    let body = format!("vec4f({pair}.first.xy, {pair}.second.yz)");
    // Drivers may round either way, by one part in 2048 or half the smallest step.
    compare("half_pairs", &body, 5e-4, input, |[a, b]| {
        let pair = half_pairs::pack_color_pair(a.truncate(), b.truncate());
        let [first, second] = half_pairs::unpack_color_pair(pair);
        Vec4::new(first.x, first.y, second.y, second.z)
    });
}
