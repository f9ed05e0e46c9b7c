//! Shader functions against their Rust twins over random inputs, on whatever adapter there is.

use glam::{Vec2, Vec3, Vec4};
use gnomon_envmap::{Equirect, Sh9};
use gnomon_shaders::layout::GROUP_SURFACE;
use gnomon_shaders::twin::{half_pairs, hemisphere, math, resample};
use gnomon_testing::tolerances::SHADER_TWIN;

use crate::bindings::Binding;
use crate::gpu::ReadBack;
use crate::materials::tables::{self, PackedTables, TableTextures};
use crate::{Gpu, GpuOptions};

mod bumps;
mod gbuffer_packing;
mod lights;
mod reflectance;
mod shadows;

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
    // What reflectances that are tables read.
    let tables_layout = gpu.layout("tables", wgpu::ShaderStages::COMPUTE, &tables::bindings());
    let tables = TableTextures::new(gpu, &PackedTables::new(reflectance::TABLES.iter()));
    let groups = [(0, &layout), (GROUP_SURFACE, &tables_layout)];
    let pipeline = gpu.new_compute_pipeline(&shader, "twin", &groups);
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
        pass.set_bind_group(GROUP_SURFACE, &tables.group, &[]);
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
fn grounds_that_fade() {
    let share = |u: Vec4, _| [Vec4::new(5.0 * u.x, u.y, u.y + 0.1 + u.z, 0.0), Vec4::ZERO];
    compare("ground", "vec4f(ground_share(a.x, a.y, a.z), 0.0, 0.0, 0.0)", 1e-5, share, |[a, _]| {
        scalar(gnomon_scene::ground_share(a.x, a.y, a.z))
    });
    // Places up to three metres away, seen from both sides; half of them from no height.
    let seen = |u: Vec4, v: Vec4| {
        [Vec4::new(6.0 * u.x - 3.0, 6.0 * u.y - 3.0, 2.0 * u.z - 1.0, u.w), unit_vector(v).extend(v.w)]
    };
    let body = "vec4f(ground_direction(vec3f(a.x, 0.0, a.y), b.xyz, a.z, b.w), 0.0)";
    compare("ground", body, SHADER_TWIN, seen, |[a, b]| {
        gnomon_scene::ground_direction(Vec3::new(a.x, 0.0, a.y), b.truncate(), a.z, b.w).extend(0.0)
    });
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
