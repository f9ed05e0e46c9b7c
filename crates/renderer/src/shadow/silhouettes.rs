//! Which triangles face each light of a batch, and the edges that bound them: found on the GPU wherever the frame has the vertices.

use gnomon_shaders::layout;

use super::technique::{FrameInputs, ShadowContext};
use crate::bindings::Binding;
use crate::ray_scene::edges::{EdgeScene, dispatch};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Marks for the lights of a batch.
pub(super) struct Silhouettes {
    pub marks: wgpu::Buffer,
    /// A [`layout::SilhouetteCounts`].
    pub counts: wgpu::Buffer,
    steps: Vec<Step>,
}

/// A dispatch.
struct Step {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    count: u32,
}

impl Silhouettes {
    /// Of the edges that the context's rays have.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] for more marks than a buffer holds.
    pub fn new<'a>(context: &ShadowContext<'a>) -> Result<(Self, EdgeBuffers<'a>), RenderError> {
        let gpu = context.gpu;
        let scene = context.rays.map(|rays| rays.scene);
        let Some((scene, edges)) = scene.and_then(|scene| Some((scene, scene.edges.as_ref()?))) else {
            return Err(RenderError::Device("there are no edges for shadows".to_owned()));
        };
        let words = context.size.lights.div_ceil(32).max(1);
        let counts = layout::SilhouetteCounts { words, ..edges.counts };
        let marked = u64::from(counts.triangles) + u64::from(counts.edges) + u64::from(edges.node_count);
        let bytes = 4 * marked * u64::from(words);
        if bytes > gpu.largest_storage() {
            return Err(RenderError::OverLimit {
                what: "bytes of the lights' silhouettes",
                wanted: bytes,
                limit: gpu.largest_storage(),
                adapter: gpu.adapter().name.clone(),
            });
        }
        let uniform = wgpu::BufferUsages::UNIFORM;
        let marks = gpu.empty_buffer("silhouettes", bytes, wgpu::BufferUsages::STORAGE);
        let counts_buffer = gpu.shared_buffer("silhouette counts", &counts, uniform);
        let buffers = EdgeBuffers { nodes: &scene.nodes, triangles: &scene.triangles, scene: edges };
        let all = gpu.buffer_with("all triangles", bytemuck::bytes_of(&[0, counts.triangles]), uniform);
        let marking = Marking::new(gpu, context, &marks, &counts_buffer, &buffers)?;
        let mut steps = vec![marking.step("mark_triangles", &all, counts.triangles)];
        for (height, level) in edges.levels.iter().enumerate() {
            let entry = if height == 0 { "mark_edges" } else { "mark_nodes" };
            steps.push(marking.step(entry, &level.range, level.count));
        }
        Ok((Self { marks, counts: counts_buffer, steps }, buffers))
    }

    /// Marks them for the frame's lights and vertices.
    pub fn encode(&self, recorder: &mut Recorder<'_>, frame: &FrameInputs<'_>) -> Result<(), RenderError> {
        if !frame.same_lights {
            for step in self.steps.iter().filter(|step| step.count > 0) {
                let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&step.pipeline);
                pass.set_bind_group(layout::GROUP_FRAME, frame.frame, &[]);
                pass.set_bind_group(layout::GROUP_PASS, &step.group, &[]);
                dispatch(&mut pass, step.count);
            }
        }
        recorder.end_pass("silhouettes")
    }
}

/// What is known of edges beside marks.
pub(super) struct EdgeBuffers<'a> {
    pub nodes: &'a wgpu::Buffer,
    pub triangles: &'a wgpu::Buffer,
    pub scene: &'a EdgeScene,
}

/// What steps are made with.
struct Marking<'a> {
    gpu: &'a Gpu,
    shader: crate::bindings::Shader,
    layout: wgpu::BindGroupLayout,
    frame: &'a wgpu::BindGroupLayout,
    /// By their bindings.
    buffers: [&'a wgpu::Buffer; 6],
}

impl<'a> Marking<'a> {
    fn new(
        gpu: &'a Gpu,
        context: &'a ShadowContext<'_>,
        marks: &'a wgpu::Buffer,
        counts: &'a wgpu::Buffer,
        edges: &'a EdgeBuffers<'_>,
    ) -> Result<Self, RenderError> {
        let read = Binding::Storage { read_only: true };
        let write = Binding::Storage { read_only: false };
        let bindings = [
            (0, Binding::Uniform),
            (1, read),
            (2, read),
            (3, read),
            (4, write),
            (5, read),
            (6, Binding::Uniform),
        ];
        let buffers =
            [counts, edges.nodes, edges.triangles, &edges.scene.edges, marks, &edges.scene.by_height];
        Ok(Self {
            gpu,
            shader: gpu.shader("silhouettes", &[])?,
            layout: gpu.layout("silhouettes", wgpu::ShaderStages::COMPUTE, &bindings),
            frame: &context.shared.frame,
            buffers,
        })
    }

    fn step(&self, entry: &str, range: &wgpu::Buffer, count: u32) -> Step {
        let buffers = self.buffers.iter().chain(std::iter::once(&range));
        let resources: Vec<_> =
            (0..).zip(buffers).map(|(number, buffer)| (number, buffer.as_entire_binding())).collect();
        let groups = [(layout::GROUP_FRAME, self.frame), (layout::GROUP_PASS, &self.layout)];
        Step {
            pipeline: self.gpu.compute_pipeline(&self.shader, entry, &groups),
            group: self.gpu.bind_group("silhouettes", &self.layout, &resources),
            count,
        }
    }
}
