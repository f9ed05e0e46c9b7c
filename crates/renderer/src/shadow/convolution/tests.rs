//! Filtered images and average blocker depths against sums over the same map on the CPU.

use gnomon_shaders::twin::series;
use gnomon_testing::tolerances;

use super::*;
use crate::gpu::ReadBack;
use crate::recorder::{Clock, new_encoder};
use crate::twins::gpu_or_skip;

const SIZE: usize = 64;

/// Depth maps of one light that hold `depths`, row by row.
fn depth_maps(gpu: &Gpu, depths: &[f32]) -> DepthMaps {
    let source = format!(
        "@group(0) @binding(0) var<storage, read> depths: array<f32>;
        @vertex fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {{
            return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
        }}
        @fragment fn stored(@builtin(position) p: vec4f) -> @builtin(frag_depth) f32 {{
            return depths[u32(p.y) * {SIZE}u + u32(p.x)];
        }}"
    );
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("depths"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let layout =
        gpu.layout("depths", wgpu::ShaderStages::FRAGMENT, &[(0, Binding::Storage { read_only: true })]);
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depths"),
        layout: Some(&gpu.pipeline_layout(&[(0, &layout)])),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("cover"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: crate::shadow::depth_maps::DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("stored"),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    let buffer = gpu.buffer_with("depths", bytemuck::cast_slice(depths), wgpu::BufferUsages::STORAGE);
    let group = gpu.bind_group("depths", &layout, &[(0, buffer.as_entire_binding())]);
    let maps = DepthMaps::new(gpu, MapDepth::Linear, 1, SIZE as u32);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depths"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &maps.layers[0],
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
    gpu.queue.submit([encoder.finish()]);
    maps
}

/// A lookup: place in the map and half width and height of the box, all in texels.
type Lookup = [f32; 4];

/// Runs `body`, an expression of type vec4f of a `Kernel` named `kernel` and of `uv`, for each of `lookups`.
fn evaluate(
    gpu: &Gpu,
    settings: &ConvolutionSettings,
    depths: &[f32],
    kernel: &str,
    body: &str,
    lookups: &[Lookup],
) -> Vec<[f32; 4]> {
    let maps = depth_maps(gpu, depths);
    let resources = Filtered::new(gpu, settings, &maps).unwrap();
    let mut encoder = new_encoder(gpu);
    let mut recorder = Recorder::new(gpu, &mut encoder, Clock::Off);
    resources.encode(&mut recorder, 1);
    gpu.queue.submit([encoder.finish()]);
    let shadows = ShadowSettings { convolution: settings.clone(), ..Default::default() };
    let source = format!(
        "{}
        @group(GROUP_PASS) @binding(0) var<storage, read> lookups: array<vec4f>;
        @group(GROUP_PASS) @binding(1) var<storage, read_write> results: array<vec4f>;
        @compute @workgroup_size(64) fn lookup(@builtin(global_invocation_id) id: vec3u) {{
            if id.x >= arrayLength(&lookups) {{ return; }}
            let uv = lookups[id.x].xy / parameters.resolution;
            let half_texels = lookups[id.x].zw;
            let kernel = {kernel};
            results[id.x] = {body};
        }}",
        gnomon_shaders::resolve(Convolution.module(&shadows), &[]).unwrap()
    );
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("lookup"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let bindings = [(0, Binding::Storage { read_only: true }), (1, Binding::Storage { read_only: false })];
    let own = gpu.layout("lookup", wgpu::ShaderStages::COMPUTE, &bindings);
    let groups = [(layout::GROUP_SHADOW, resources.layout()), (layout::GROUP_PASS, &own)];
    let pipeline = gpu.new_compute_pipeline(&module, "lookup", &groups);
    let size = 16 * lookups.len() as u64;
    let input = gpu.buffer_with("lookups", bytemuck::cast_slice(lookups), wgpu::BufferUsages::STORAGE);
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let output = gpu.empty_buffer("results", size, usage);
    let mapped =
        gpu.empty_buffer("mapped", size, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group =
        gpu.bind_group("lookup", &own, &[(0, input.as_entire_binding()), (1, output.as_entire_binding())]);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(layout::GROUP_SHADOW, resources.bind_group(), &[]);
        pass.set_bind_group(layout::GROUP_PASS, &group, &[]);
        pass.dispatch_workgroups(lookups.len().div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &mapped, 0, size);
    let read_back = ReadBack::of_buffer(gpu, &encoder, mapped);
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.wait_for(read_back).unwrap();
    bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&bytes)[..lookups.len()].to_vec()
}

const SAT_KERNEL: &str = "Kernel(half_texels)";
/// The level whose variance is that of the box: h^2 / 3 against 5 / 12 of a texel's square.
const MIP_KERNEL: &str = "Kernel(level_from_width(half_texels.x * sqrt(0.8)))";

/// Mean of `value` over a box of a map, texels at its rim in part and what lies outside the map at depth 1.
fn box_mean(depths: &[f32], [x, y, half_x, half_y]: Lookup, value: &dyn Fn(f64) -> f64) -> f64 {
    let covered = |center: f32, half: f32, texel: i32| {
        let (low, high) = (f64::from(center - half), f64::from(center + half));
        (high.min(f64::from(texel + 1)) - low.max(f64::from(texel))).max(0.0)
    };
    let range = |center: f32, half: f32| (center - half).floor() as i32..=(center + half).floor() as i32;
    let mut sum = 0.0;
    for row in range(y, half_y) {
        for column in range(x, half_x) {
            let inside = (0..SIZE as i32).contains(&row) && (0..SIZE as i32).contains(&column);
            let depth = if inside { depths[row as usize * SIZE + column as usize] } else { 1.0 };
            sum += covered(x, half_x, column) * covered(y, half_y, row) * value(f64::from(depth));
        }
    }
    sum / (4.0 * f64::from(half_x) * f64::from(half_y))
}

/// Everything that a depth map has: slopes, steps, noise, and gaps in which nothing blocks.
fn depths() -> Vec<f32> {
    let texel = |i: usize| {
        let (x, y) = (i % SIZE, i / SIZE);
        match ((x / 9 + y / 13) % 4, (x * 7919 + y * 104_729) % 97) {
            (0, _) => 1.0,
            (1, noise) => 0.2 + 0.005 * noise as f32,
            (2, _) => 0.4 + 0.008 * x as f32 - 0.002 * y as f32,
            _ => 0.75,
        }
    };
    (0..SIZE * SIZE).map(texel).collect()
}

/// Waves much longer than the kernels, on which every kernel of one variance gives the same mean.
fn smooth_depths() -> Vec<f32> {
    let texel = |i: usize| {
        let (x, y) = ((i % SIZE) as f32, (i / SIZE) as f32);
        0.5 + 0.05 * (0.1 * x + 0.3).sin() + 0.05 * (0.08 * y).cos()
    };
    (0..SIZE * SIZE).map(texel).collect()
}

/// `c_k` times the scale of depths.
fn frequency(k: usize) -> f64 {
    std::f64::consts::PI * (2 * k + 1) as f64 * f64::from(series::SERIES_DEPTH_SCALE)
}

/// Largest difference of the filtered first four sines and cosines from the box's mean.
fn worst(gpu: &Gpu, prefilter: Prefilter, depths: &[f32], drawn: &[f32], lookups: &[Lookup]) -> f64 {
    let settings = ConvolutionSettings { prefilter, ..Default::default() };
    let kernel = if prefilter == Prefilter::MipChain { MIP_KERNEL } else { SAT_KERNEL };
    let images = [("basis_sin", "far_sin", f64::sin as fn(f64) -> f64), ("basis_cos", "far_cos", f64::cos)];
    let mut worst = 0.0_f64;
    for (image, far, wave) in images {
        let body = format!("filtered({image}, uv, 0u, kernel, parameters.{far}[0])");
        let found = evaluate(gpu, &settings, drawn, kernel, &body, lookups);
        for (found, lookup) in found.iter().zip(lookups) {
            for (k, found) in found.iter().enumerate() {
                let mean = box_mean(depths, *lookup, &|z| wave(frequency(k) * z));
                worst = worst.max((f64::from(*found) - mean).abs());
            }
        }
    }
    worst
}

#[test]
fn summed_area_tables_give_the_mean_over_any_box() {
    let Some(gpu) = gpu_or_skip() else { return };
    // Boxes of one texel and of the whole map, across the rim, wide and high ones, anywhere between the texels.
    let lookups: Vec<Lookup> = (0..200)
        .map(|i| {
            let at = |step: f32| (i as f32 * step).fract();
            let (half_x, half_y) = (0.5 * 100_f32.powf(at(0.618_034)), 0.5 * 100_f32.powf(at(0.414_214)));
            [64.0 * at(0.754_878), 64.0 * at(0.569_84), half_x, half_y]
        })
        .collect();
    let depths = depths();
    let error = worst(&gpu, Prefilter::SummedAreaTable, &depths, &depths, &lookups);
    println!("summed-area table: off by {error:.1e}");
    assert!(error <= tolerances::SUMMED_AREA_MEAN, "{error}");

    let mut faulty = depths.clone();
    faulty[SIZE * 20 + 20] = 0.3;
    let error = worst(&gpu, Prefilter::SummedAreaTable, &depths, &faulty, &lookups);
    assert!(error > tolerances::SUMMED_AREA_MEAN, "one wrong texel: {error}");
}

#[test]
fn mip_chains_give_the_mean_over_a_box_of_the_same_variance() {
    let Some(gpu) = gpu_or_skip() else { return };
    let depths = smooth_depths();
    // Away from the rim: clamped texels stand for what lies outside there.
    let lookups: Vec<Lookup> = (0..100)
        .map(|i| {
            let at = |step: f32| (i as f32 * step).fract();
            let half = 1.2 * 5_f32.powf(at(0.618_034));
            [20.0 + 24.0 * at(0.754_878), 20.0 + 24.0 * at(0.569_84), half, half]
        })
        .collect();
    let error = worst(&gpu, Prefilter::MipChain, &depths, &depths, &lookups);
    println!("mip chain: off by {error:.4}");
    assert!(error <= tolerances::MIP_MEAN, "{error}");

    // Kernels half as wide again are no longer the same mean.
    let wider: Vec<Lookup> = lookups.iter().map(|[x, y, w, h]| [*x, *y, 2.0 * w, 2.0 * h]).collect();
    let settings = ConvolutionSettings::default();
    let body = "filtered(basis_sin, uv, 0u, kernel, parameters.far_sin[0])";
    let found = evaluate(&gpu, &settings, &depths, MIP_KERNEL, body, &wider);
    let error = (found.iter().zip(&lookups))
        .map(|(found, lookup)| {
            let mean = box_mean(&depths, *lookup, &|z| (frequency(3) * z).sin());
            (f64::from(found[3]) - mean).abs()
        })
        .fold(0.0, f64::max);
    assert!(error > tolerances::MIP_MEAN, "kernels of twice the width: {error}");
}

#[test]
fn average_blocker_depth_is_that_of_the_kernel() {
    let Some(gpu) = gpu_or_skip() else { return };
    // Blockers from 0.1 to 0.35 in stripes, gaps that show the far plane between them; receiver at 0.68.
    let depths: Vec<f32> = (0..SIZE * SIZE)
        .map(|i| {
            let (x, y) = (i % SIZE, i / SIZE);
            if (x / 3 + y / 5) % 2 == 0 {
                0.1 + 0.25 * (x * 31 + y * 17 % 64) as f32 % 64.0 / 64.0
            } else {
                1.0
            }
        })
        .collect();
    let d = 0.68_f32;
    let lookups: Vec<Lookup> = (0..60)
        .map(|i| {
            let at = |step: f32| (i as f32 * step).fract();
            let half = 5.0 + 10.0 * at(0.618_034);
            [20.0 + 24.0 * at(0.754_878), 20.0 + 24.0 * at(0.569_84), half, half]
        })
        .collect();
    let mean = |lookup: &Lookup, d: f32| {
        let blocks = |z: f64| if z < f64::from(d) { 1.0 } else { 0.0 };
        box_mean(&depths, *lookup, &|z| z * blocks(z)) / box_mean(&depths, *lookup, &blocks)
    };
    let scale = series::SERIES_DEPTH_SCALE;
    let worst = |order: u32, truth_at: f32| {
        let settings =
            ConvolutionSettings { order, prefilter: Prefilter::SummedAreaTable, ..Default::default() };
        let d = scale * d;
        let body = format!(
            "vec4f(average_blocker_depth(0u, Lookup(uv, kernel), {d}, filtered_lit(0u, Lookup(uv, kernel), {d})), 0.0, 0.0, 0.0)"
        );
        (evaluate(&gpu, &settings, &depths, SAT_KERNEL, &body, &lookups).iter().zip(&lookups))
            .map(|(found, lookup)| (f64::from(found[0] / scale) - mean(lookup, truth_at)).abs())
            .fold(0.0, f64::max)
    };
    let (fine, coarse) = (worst(16, d), worst(4, d));
    println!("average blocker depth: off by {fine:.4} with 16 terms, {coarse:.4} with 4");
    assert!(fine <= tolerances::BLOCKER_DEPTH_16, "{fine}");
    assert!(coarse <= tolerances::BLOCKER_DEPTH_4, "{coarse}");
    // A receiver among the blockers has others in front of it.
    assert!(worst(4, 0.2) > tolerances::BLOCKER_DEPTH_4);
}
