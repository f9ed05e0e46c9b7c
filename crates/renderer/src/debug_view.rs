//! What a frame is made of, shown in place of its picture. To add a view: a VIEW constant, an entry in [`DEBUG_VIEWS`] and a
//! case in `debug_view.wgsl`.

use gnomon_shaders::layout;

use crate::bindings::{Binding, D2_ARRAY, set_groups};
use crate::models::Models;
use crate::recorder::Recorder;
use crate::shadow::depth_maps::{DepthMaps, MapDepth};
use crate::{Gpu, RenderError};

/// Something to be shown in place of the picture.
#[derive(Debug, PartialEq, Eq)]
pub struct DebugView {
    /// Name for people and files.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    /// Whether it is about one light, which can be chosen.
    pub of_light: bool,
    /// A VIEW constant.
    code: u32,
}

const fn view(name: &'static str, summary: &'static str, of_light: bool, code: u32) -> DebugView {
    DebugView { name, summary, of_light, code }
}

/// Every view; the first is the picture itself.
pub const DEBUG_VIEWS: &[DebugView] = &[
    view("final", "the picture", false, 0),
    view("normals", "shading normals: x, y, z from -1 to 1 as red, green, blue", false, layout::VIEW_NORMALS),
    view("depth", "distance along the view: nearer is lighter", false, layout::VIEW_DEPTH),
    view("base-color", "base colour of the materials, without light", false, layout::VIEW_BASE_COLOR),
    view("shadow-buffer", "share of the lights' irradiance that arrives", false, layout::VIEW_SHADOW_BUFFER),
    view(
        "visibility",
        "share of one light that is seen; blue where it is below the horizon",
        true,
        layout::VIEW_VISIBILITY,
    ),
    view(
        "shadow-map",
        "one light's shadow map: nearer is lighter, blue is empty",
        true,
        layout::VIEW_SHADOW_MAP,
    ),
    view("lights", "the lights on the environment map; the chosen one is white", true, layout::VIEW_LIGHTS),
    view(
        "points",
        "where lights are summed: white for a tile, red for a sample of its own",
        false,
        layout::VIEW_POINTS,
    ),
    view("bumps", "share of the hemisphere that bumps leave open", false, layout::VIEW_BUMPS),
    view(
        "scattered",
        "irradiance that bumps scatter to each other, under a uniform sky of 1",
        false,
        layout::VIEW_SCATTERED,
    ),
];

/// The view called `name`; `None` for the picture itself.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub(crate) fn by_name(name: &str) -> Result<Option<&'static DebugView>, RenderError> {
    let found =
        DEBUG_VIEWS.iter().find(|view| view.name == name).ok_or_else(|| RenderError::UnknownName {
            what: "debug view",
            name: name.to_owned(),
            choices: DEBUG_VIEWS.iter().map(|view| view.name).collect::<Vec<_>>().join(", "),
        })?;
    Ok((found.code != 0).then_some(found))
}

impl DebugView {
    /// Whether only the chosen light is summed.
    pub(crate) fn sums_one_light(&self) -> bool {
        self.name == "visibility"
    }

    /// Whether the lights of all batches are drawn, rather than the chosen one's.
    pub(crate) fn draws_all_lights(&self) -> bool {
        self.name == "lights"
    }

    /// Whether the chosen light's depth map is read.
    pub(crate) fn reads_map(&self) -> bool {
        self.name == "shadow-map"
    }

    /// What the shader is told, but for what depends on batch and camera.
    pub(crate) fn parameters(&self) -> layout::DebugParameters {
        layout::DebugParameters { view: self.code, ..Default::default() }
    }
}

/// Draws one of the views in place of composing.
pub(crate) struct DebugPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    /// In place of the maps of a technique without any.
    no_maps: DepthMaps,
}

/// Bind group of the frame for a batch.
pub(crate) struct DebugGroup {
    pub parameters: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl DebugPass {
    /// Layouts of the G-buffer and of the sums.
    pub fn new(gpu: &Gpu, [gbuffer, sums]: [&wgpu::BindGroupLayout; 2]) -> Result<Self, RenderError> {
        let bindings = [
            (0, Binding::Uniform),
            (1, Binding::Uniform),
            (2, Binding::LOADED),
            (3, Binding::Depth { dimension: D2_ARRAY }),
            (4, Binding::Uniform),
        ];
        let frame = gpu.layout("debug view", wgpu::ShaderStages::COMPUTE, &bindings);
        let groups =
            [(layout::GROUP_FRAME, &frame), (layout::GROUP_SURFACE, gbuffer), (layout::GROUP_PASS, sums)];
        // Scenes change while it stands.
        let shader = gpu.with_models(Models::all()).shader("debug_view", &[])?;
        let pipeline = gpu.compute_pipeline(&shader, "debug_view", &groups);
        Ok(Self { layout: frame, pipeline, no_maps: DepthMaps::new(gpu, MapDepth::Linear, 0, 1) })
    }

    /// For a batch with these lights and maps.
    pub fn group(
        &self,
        gpu: &Gpu,
        view: &wgpu::Buffer,
        background: &wgpu::TextureView,
        lights: &wgpu::Buffer,
        maps: Option<&DepthMaps>,
    ) -> DebugGroup {
        let size = layout::size::<layout::DebugParameters>();
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let parameters = gpu.empty_buffer("debug view", size, usage);
        let resources = [
            (0, view.as_entire_binding()),
            (1, parameters.as_entire_binding()),
            (2, wgpu::BindingResource::TextureView(background)),
            (3, wgpu::BindingResource::TextureView(&maps.unwrap_or(&self.no_maps).array)),
            (4, lights.as_entire_binding()),
        ];
        DebugGroup { group: gpu.bind_group("debug view", &self.layout, &resources), parameters }
    }

    /// `groups` are the G-buffer and the sums. Batches are drawn one over the other.
    pub fn encode<'a>(
        &self,
        recorder: &mut Recorder<'_>,
        batches: impl Iterator<Item = &'a DebugGroup>,
        [gbuffer, sums]: [&wgpu::BindGroup; 2],
        [width, height]: [u32; 2],
    ) {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        set_groups(&mut pass, &[(layout::GROUP_SURFACE, gbuffer), (layout::GROUP_PASS, sums)]);
        for batch in batches {
            pass.set_bind_group(layout::GROUP_FRAME, &batch.group, &[]);
            pass.dispatch_workgroups(width.div_ceil(layout::TILE), height.div_ceil(layout::TILE), 1);
        }
    }
}
