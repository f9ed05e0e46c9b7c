use gnomon_shaders::layout;

use crate::bindings::{Binding, D2, D2_ARRAY, set_groups};
use crate::compose::{Composed, RADIANCE_FORMAT};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError, TechniqueSettings};

/// Samples of the picture that lights are summed at, and the sums: the shadow buffer (DeCoro and Rusinkiewicz 2008, section 3.2). One
/// point stands for a tile of samples; samples unlike the points around them have their own. Points are listed in stages.
pub(crate) struct ShadingPoints {
    pub stages: Vec<PointStage>,
    /// Own bind groups of the passes that make a picture of the sums, layer by layer: over all pixels, and over edge pixels.
    pub compose_groups: Vec<[wgpu::BindGroup; 2]>,
    /// A [`layout::Composition`] for each of these.
    composed: Vec<[wgpu::Buffer; 2]>,
    /// Average the sums of grainy light, and put that in place: few scenes need them.
    even_passes: Option<[wgpu::ComputePipeline; 2]>,
    /// Account of points: arguments of indirect dispatches, edge pixels.
    pub work: wgpu::Buffer,
    /// The points themselves, [`layout::ShadingPoint`]s.
    pub list: wgpu::Buffer,
    /// Arguments of dispatches over edge pixels and over the points of a stage, for passes that write to `work`.
    edge_dispatch: wgpu::Buffer,
    stage_dispatch: wgpu::Buffer,
    /// How many there is room for.
    pub capacity: u64,
    /// What it was made for.
    pub plan: PointPlan,
}

/// Points that are listed at a time; light is summed there before the next stage.
pub(crate) struct PointStage {
    /// Place of the list they belong to.
    pub list: usize,
    /// A [`layout::PointStage`].
    pub uniform: wgpu::Buffer,
    /// Own bind group of the pass that sums light.
    pub light_group: wgpu::BindGroup,
    /// Own bind group of the passes that even the sums out, where they are of grainy light.
    even_group: Option<wgpu::BindGroup>,
    /// Place in [`ShadingPoints::work`] of the arguments of a dispatch over these points.
    pub dispatch_offset: u64,
    /// Bind groups of the passes that list points: over the picture, and over edge pixels.
    list_groups: [wgpu::BindGroup; 2],
    kind: StageKind,
}

/// What a stage lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StageKind {
    /// A point of every tile, and of samples that no tile stands for.
    Tiles,
    /// Points where visibility changes between those before.
    Lit,
}

/// Lists the points of a frame.
pub(crate) struct ShadingPointsPass {
    list_layout: wgpu::BindGroupLayout,
    pub light_layout: wgpu::BindGroupLayout,
    pub compose_layout: wgpu::BindGroupLayout,
    find_edges: wgpu::ComputePipeline,
    edge_dispatch: wgpu::ComputePipeline,
    choose: wgpu::ComputePipeline,
    refine: wgpu::ComputePipeline,
    refine_lit: wgpu::ComputePipeline,
    inherit: wgpu::ComputePipeline,
    end_stage: wgpu::ComputePipeline,
    even_layout: wgpu::BindGroupLayout,
    /// Of view and G-buffer.
    shared_layouts: [wgpu::BindGroupLayout; 2],
}

/// Bytes of what is kept for every shading point: the point, and what light gives it.
const POINT_BYTES: u64 = 20;
const DIFFUSE_BYTES: u64 = 16;
const SPECULAR_BYTES: u64 = 12;
const NEAR_BYTES: u64 = 12;
const LIT_SHARE_BYTES: u64 = 16;

/// Samples for which there is room for one point beside those of tiles, in large pictures. Where more are wanted, the last ones take what the
/// tiles around them have.
const SAMPLES_OF_POINT: u64 = 10;
/// So many points have room in any case, up to one for every sample: smaller pictures have more edges for their size.
const LEAST_POINTS: u64 = 1 << 21;

/// What a scene needs beside sums of diffuse light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SumPlanes {
    /// Some surface is glossy.
    pub specular: bool,
    /// The scene has lights of its own.
    pub near: bool,
    /// Sums are kept in floats, not in halves.
    pub wide: bool,
    /// Sums of lights are of few rays, and no light is a probe: they are averaged ([`layout::FLAG_EVENED_SUMS`]).
    pub evened: bool,
}

impl SumPlanes {
    /// Bytes for each point of diffuse, specular and near light.
    fn bytes(self) -> [u64; 3] {
        let wide = if self.wide { 2 } else { 1 };
        let kept = |is_kept: bool, bytes: u64| if is_kept { wide * bytes } else { 0 };
        [kept(true, DIFFUSE_BYTES), kept(self.specular, SPECULAR_BYTES), kept(self.near, NEAR_BYTES)]
    }
}

/// The lists of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointPlan {
    pub sample_size: [u32; 2],
    /// Samples along a pixel's side.
    pub supersample: u32,
    /// Samples along the side of a tile of each list, the coarsest first.
    pub samplings: Vec<u32>,
    /// Least change of visibility between neighbouring points for which there are more.
    pub contrast: f32,
    pub planes: SumPlanes,
}

/// Samples along the side of a tile of each list that lights are summed at: wide lights at the first, sharp ones at the last.
pub(crate) fn samplings(techniques: &TechniqueSettings) -> Vec<u32> {
    let (wide, sharp) = (techniques.shadow_sampling, techniques.sharp_shadow_sampling);
    if sharp < wide { vec![wide, sharp] } else { vec![wide] }
}

impl ShadingPoints {
    /// What is composed from the next submission on, a PART constant.
    pub fn compose_part(&self, gpu: &Gpu, part: u32) {
        let layer_count = self.composed.len() as u32 - 1;
        for (layer, pair) in (0..).zip(&self.composed) {
            for (over_edges, buffer) in (0..).zip(pair) {
                gpu.write(buffer, &layout::Composition { over_edges, part, layer, layer_count });
            }
        }
    }
}

impl PointStage {
    /// Whether these are the first points of their list.
    pub fn lists_tiles(&self) -> bool {
        self.kind == StageKind::Tiles
    }
}

impl PointPlan {
    pub fn new(techniques: &TechniqueSettings, size: [u32; 2], planes: SumPlanes) -> Self {
        Self {
            sample_size: size.map(|side| side * techniques.supersample),
            supersample: techniques.supersample,
            samplings: samplings(techniques),
            contrast: techniques.shadow_contrast,
            planes,
        }
    }

    fn samples(&self) -> u64 {
        self.sample_size.map(u64::from).into_iter().product()
    }

    fn pixels(&self) -> u64 {
        self.samples() / u64::from(self.supersample).pow(2)
    }

    fn tiles(&self, list: usize) -> u64 {
        self.sample_size.map(|side| u64::from(side.div_ceil(self.samplings[list]))).into_iter().product()
    }

    fn all_tiles(&self) -> u64 {
        (0..self.samplings.len()).map(|list| self.tiles(list)).sum()
    }

    /// Room for points: those of tiles, and of samples that no tile stands for.
    fn capacity(&self) -> u64 {
        let own = match self.samplings[..] {
            [1] => 0,
            _ => (self.samples() / SAMPLES_OF_POINT).max(LEAST_POINTS).min(self.samples()),
        };
        // Buffers have a least size: so many points fill it.
        (self.all_tiles() + own).max(16)
    }

    /// Whether a list has points beside those of tiles.
    fn has_own_points(&self) -> bool {
        self.samplings[..] != [1]
    }

    /// Bytes of the largest buffer.
    pub fn largest_buffer(&self) -> u64 {
        let largest_plane = self.planes.bytes().into_iter().max().unwrap_or(0);
        let points = self.capacity() * POINT_BYTES.max(largest_plane);
        let own = if self.has_own_points() { 4 * self.samples() } else { 4 };
        points.max(own).max(self.work_bytes())
    }

    fn work_bytes(&self) -> u64 {
        4 * (u64::from(layout::WORK_PIXELS) + 2 * self.pixels())
    }

    /// The lists as shaders see them.
    pub fn lists(&self) -> [layout::PointList; 2] {
        std::array::from_fn(|list| match self.samplings.get(list) {
            Some(&sampling) => layout::PointList {
                sampling,
                first_tile: (0..list).map(|before| self.tiles(before)).sum::<u64>() as u32,
                first_stage: 2 * list as u32,
                reserved: 0,
            },
            None => layout::PointList::default(),
        })
    }

    /// Every stage: first the tiles of a list, then what their light asks for.
    fn stages(&self) -> impl Iterator<Item = (StageKind, layout::PointStage)> + '_ {
        (0..self.samplings.len()).flat_map(move |list| {
            [StageKind::Tiles, StageKind::Lit].into_iter().enumerate().map(move |(i, kind)| {
                let is_coarse = list + 1 < self.samplings.len();
                let stage = layout::PointStage {
                    list: list as u32,
                    stage: (2 * list + i) as u32,
                    block: self.block(kind, is_coarse),
                    contrast: self.contrast,
                    over_edges: 0,
                };
                (kind, stage)
            })
        })
    }

    /// Samples along the side of a block of which one may stand for the others; a divisor of a pixel's. In the last list, where sharp
    /// lights are summed, blocks are smaller.
    fn block(&self, kind: StageKind, is_coarse: bool) -> u32 {
        let side = self.supersample;
        let most = match (kind, is_coarse) {
            // A highlight may be narrower than a pixel.
            (_, true) if self.planes.specular => (side / 2).clamp(1, 2),
            (StageKind::Tiles, true) => 4,
            (StageKind::Lit, true) => side,
            (StageKind::Tiles, false) if !self.planes.specular => (side / 2).clamp(1, 2),
            (_, false) => 1,
        };
        (1..=most).rev().find(|block| side.is_multiple_of(*block)).unwrap_or(1)
    }
}

impl ShadingPointsPass {
    pub fn new(
        gpu: &Gpu,
        view_layout: &wgpu::BindGroupLayout,
        gbuffer_layout: &wgpu::BindGroupLayout,
    ) -> Result<Self, RenderError> {
        let written = Binding::Storage { read_only: false };
        let read = Binding::Storage { read_only: true };
        let numbered = |label, bindings: &[Binding]| {
            let bindings: Vec<_> = (0..).zip(bindings.iter().copied()).collect();
            gpu.layout(label, wgpu::ShaderStages::COMPUTE, &bindings)
        };
        let mut listed = vec![written; 7];
        listed.push(Binding::Uniform);
        let list_layout = numbered("shading points", &listed);
        let module = gpu.shader("shading_points", &[])?;
        let picture = Binding::StorageTexture { format: RADIANCE_FORMAT, dimension: D2 };
        let layers = Binding::Texture { dimension: D2_ARRAY, filterable: false };
        let groups = [
            (layout::GROUP_FRAME, view_layout),
            (layout::GROUP_SURFACE, gbuffer_layout),
            (layout::GROUP_PASS, &list_layout),
        ];
        let pipeline = |entry| gpu.compute_pipeline(&module, entry, &groups);
        Ok(Self {
            even_layout: numbered(
                "sums to even out",
                &[read, read, read, written, written, Binding::Uniform],
            ),
            shared_layouts: [view_layout, gbuffer_layout].map(Clone::clone),
            light_layout: numbered(
                "sums of light",
                &[read, read, written, written, written, Binding::Uniform],
            ),
            compose_layout: numbered(
                "sums to compose",
                &[
                    read,
                    read,
                    read,
                    read,
                    read,
                    read,
                    read,
                    picture,
                    Binding::Uniform,
                    layers,
                    Binding::LOADED,
                ],
            ),
            find_edges: pipeline("find_edges"),
            edge_dispatch: pipeline("edge_dispatch"),
            choose: pipeline("choose"),
            refine: pipeline("refine"),
            refine_lit: pipeline("refine_lit"),
            inherit: pipeline("inherit"),
            end_stage: pipeline("end_stage"),
            list_layout,
        })
    }

    /// Buffers for a picture, which becomes `target`, and the opacities of its layers.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] where the adapter allows no buffer that large.
    pub fn points(
        &self,
        gpu: &Gpu,
        plan: PointPlan,
        target: &Composed,
        (layer_count, opacities): (u32, &wgpu::TextureView),
    ) -> Result<ShadingPoints, RenderError> {
        let capacity = plan.capacity();
        let (wanted, limit) = (plan.largest_buffer(), gpu.largest_storage());
        if wanted > limit {
            return Err(RenderError::OverLimit {
                what: "bytes to sum light at every sample (fewer samples a pixel or coarser shadow sampling need less)",
                wanted,
                limit,
                adapter: gpu.adapter().name.clone(),
            });
        }
        let storage = wgpu::BufferUsages::STORAGE;
        let points = gpu.empty_buffer("shading points", capacity * POINT_BYTES, storage);
        let work = gpu.empty_buffer(
            "account of points",
            plan.work_bytes(),
            storage
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC
                | wgpu::BufferUsages::INDIRECT,
        );
        let arguments = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::INDIRECT;
        let edge_dispatch = gpu.empty_buffer("edge dispatch", 16, arguments);
        let stage_dispatch = gpu.empty_buffer("stage dispatch", 16, arguments);
        let point_of_tile = gpu.empty_buffer("points of tiles", 4 * plan.all_tiles(), storage);
        let own = if plan.has_own_points() { plan.samples() } else { 1 };
        let point_of_sample = gpu.empty_buffer("points of samples", 4 * own, storage);
        let bytes = plan.planes.bytes();
        let plane = |label, i: usize| gpu.empty_buffer(label, capacity * bytes[i], storage);
        let diffuse = plane("sums of diffuse light", 0);
        let specular = plane("sums of specular light", 1);
        let near = plane("sums of near light", 2);
        let even_passes = plan.planes.evened.then(|| self.even_passes(gpu)).transpose()?;
        let lit_shares =
            plan.planes.evened.then(|| gpu.empty_buffer("lit shares", capacity * LIT_SHARE_BYTES, storage));
        let group = |label, layout, buffers: &[&wgpu::Buffer]| {
            let buffers = buffers.iter().map(|buffer| buffer.as_entire_binding());
            gpu.bind_group(label, layout, &(0..).zip(buffers).collect::<Vec<_>>())
        };
        let stages = plan.stages().map(|(kind, stage)| {
            let uniforms = [0, 1].map(|over_edges| {
                let stage = layout::PointStage { over_edges, ..stage };
                gpu.shared_buffer("stage", &stage, wgpu::BufferUsages::UNIFORM)
            });
            let list_group = |uniform| {
                let buffers = [&points, &work, &point_of_tile, &point_of_sample, &diffuse, &specular, &near];
                group("shading points", &self.list_layout, &[&buffers[..], &[uniform]].concat())
            };
            let light_buffers = [&points, &work, &diffuse, &specular, &near, &uniforms[0]];
            let even_group = |lit_shares| {
                let buffers = [&points, &work, &point_of_tile, &diffuse, lit_shares, &uniforms[0]];
                group("sums to even out", &self.even_layout, &buffers)
            };
            PointStage {
                even_group: lit_shares.as_ref().map(even_group),
                list: stage.list as usize,
                list_groups: [list_group(&uniforms[0]), list_group(&uniforms[1])],
                light_group: group("sums of light", &self.light_layout, &light_buffers),
                dispatch_offset: 4 * u64::from(layout::WORK_STAGES + layout::WORK_STAGE * stage.stage),
                kind,
                uniform: uniforms[0].clone(),
            }
        });
        let stages = stages.collect();
        let composed: Vec<_> = (0..=layer_count)
            .map(|layer| {
                [0, 1].map(|over_edges: u32| {
                    let part = layout::PART_PICTURE;
                    let composition = layout::Composition { over_edges, part, layer, layer_count };
                    gpu.shared_buffer("composition", &composition, wgpu::BufferUsages::UNIFORM)
                })
            })
            .collect();
        let compose_group = |composition: &wgpu::Buffer| {
            let buffers = [&points, &work, &point_of_tile, &point_of_sample, &diffuse, &specular, &near];
            let mut resources: Vec<_> = (0..).zip(buffers.map(|buffer| buffer.as_entire_binding())).collect();
            resources.push((7, wgpu::BindingResource::TextureView(&target.values)));
            resources.push((8, composition.as_entire_binding()));
            resources.push((9, wgpu::BindingResource::TextureView(opacities)));
            resources.push((10, wgpu::BindingResource::TextureView(&target.in_front)));
            gpu.bind_group("sums to compose", &self.compose_layout, &resources)
        };
        let compose_groups = composed.iter().map(|pair| pair.each_ref().map(compose_group)).collect();
        Ok(ShadingPoints {
            stages,
            compose_groups,
            composed,
            even_passes,
            list: points,
            work,
            edge_dispatch,
            stage_dispatch,
            capacity,
            plan,
        })
    }

    /// Lists the points of a stage. Light has been summed at those of the stages before.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        points: &ShadingPoints,
        stage: &PointStage,
        view_group: &wgpu::BindGroup,
        gbuffer_group: &wgpu::BindGroup,
    ) {
        let plan = &points.plan;
        if stage.list == 0 && stage.lists_tiles() {
            recorder.encoder.clear_buffer(&points.work, 0, Some(4 * u64::from(layout::WORK_PIXELS)));
        }
        let mut pass = self.begin(recorder, [view_group, gbuffer_group], stage);
        let dispatch = |pass: &mut wgpu::ComputePass<'_>, pipeline, side: u32| {
            let [columns, rows] = plan.sample_size.map(|samples| samples.div_ceil(side));
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(columns.div_ceil(layout::TILE), rows.div_ceil(layout::TILE), 1);
        };
        if stage.list == 0 && stage.lists_tiles() {
            dispatch(&mut pass, &self.find_edges, plan.supersample);
            pass.set_pipeline(&self.edge_dispatch);
            pass.dispatch_workgroups(1, 1, 1);
            drop(pass);
            let place = 4 * u64::from(layout::WORK_EDGE_DISPATCH);
            recorder.encoder.copy_buffer_to_buffer(&points.work, place, &points.edge_dispatch, 0, 16);
            pass = self.begin(recorder, [view_group, gbuffer_group], stage);
        }
        let over_edges = |pass: &mut wgpu::ComputePass<'_>, pipeline| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(layout::GROUP_PASS, &stage.list_groups[1], &[]);
            pass.dispatch_workgroups_indirect(&points.edge_dispatch, 0);
            pass.set_bind_group(layout::GROUP_PASS, &stage.list_groups[0], &[]);
        };
        let sampling = plan.samplings[stage.list];
        match stage.kind {
            StageKind::Tiles => {
                dispatch(&mut pass, &self.choose, sampling);
                if sampling > plan.supersample {
                    let is_coarse = stage.list + 1 < plan.samplings.len();
                    dispatch(&mut pass, &self.refine, plan.block(stage.kind, is_coarse));
                } else if sampling > 1 {
                    over_edges(&mut pass, &self.refine);
                }
            }
            StageKind::Lit if sampling > 1 && plan.contrast < 1.0 => {
                dispatch(&mut pass, &self.refine_lit, plan.supersample);
                over_edges(&mut pass, &self.refine_lit);
            }
            StageKind::Lit => {}
        }
        pass.set_pipeline(&self.end_stage);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        self.inherit(recorder, points, stage, [view_group, gbuffer_group]);
    }

    /// Starts the sums at a stage's points with those of the list before; its first list starts with none.
    pub fn inherit(
        &self,
        recorder: &mut Recorder<'_>,
        points: &ShadingPoints,
        stage: &PointStage,
        groups: [&wgpu::BindGroup; 2],
    ) {
        if stage.list == 0 {
            return;
        }
        let (work, place) = (&points.work, stage.dispatch_offset);
        recorder.encoder.copy_buffer_to_buffer(work, place, &points.stage_dispatch, 0, 16);
        let mut pass = self.begin(recorder, groups, stage);
        pass.set_pipeline(&self.inherit);
        pass.dispatch_workgroups_indirect(&points.stage_dispatch, 0);
    }

    fn even_passes(&self, gpu: &Gpu) -> Result<[wgpu::ComputePipeline; 2], RenderError> {
        let module = gpu.shader("even_sums", &[])?;
        let [view, gbuffer] = &self.shared_layouts;
        let groups = [
            (layout::GROUP_FRAME, view),
            (layout::GROUP_SURFACE, gbuffer),
            (layout::GROUP_PASS, &self.even_layout),
        ];
        Ok(["even_out", "keep_evened"].map(|entry| gpu.compute_pipeline(&module, entry, &groups)))
    }

    /// Averages what lights gave to a stage's points over what their shadows allow, where it is grainy.
    pub fn even_out(
        &self,
        recorder: &mut Recorder<'_>,
        points: &ShadingPoints,
        stage: &PointStage,
        [view_group, gbuffer_group]: [&wgpu::BindGroup; 2],
    ) {
        let (Some(even_group), Some(passes)) = (&stage.even_group, &points.even_passes) else { return };
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let groups = [
            (layout::GROUP_FRAME, view_group),
            (layout::GROUP_SURFACE, gbuffer_group),
            (layout::GROUP_PASS, even_group),
        ];
        set_groups(&mut pass, &groups);
        for pipeline in passes {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups_indirect(&points.work, stage.dispatch_offset);
        }
    }

    fn begin<'a>(
        &self,
        recorder: &'a mut Recorder<'_>,
        [view_group, gbuffer_group]: [&wgpu::BindGroup; 2],
        stage: &PointStage,
    ) -> wgpu::ComputePass<'a> {
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        let groups = [
            (layout::GROUP_FRAME, view_group),
            (layout::GROUP_SURFACE, gbuffer_group),
            (layout::GROUP_PASS, &stage.list_groups[0]),
        ];
        set_groups(&mut pass, &groups);
        pass
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_as_large_as_its_struct() {
        assert_eq!(layout::size::<layout::ShadingPoint>(), POINT_BYTES);
        assert_eq!(
            layout::WORK_STAGES + layout::WORK_STAGE * layout::MAX_POINT_STAGES,
            layout::WORK_EDGE_DISPATCH
        );
    }

    #[test]
    fn the_default_at_1920_x_1080_fits_what_web_gpu_guarantees() {
        let techniques = TechniqueSettings::default();
        let plan = PointPlan::new(
            &techniques,
            [1920, 1080],
            SumPlanes { specular: true, near: true, wide: false, evened: false },
        );
        let limits = wgpu::Limits::default();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        println!("{} points, the largest buffer {} bytes", plan.capacity(), plan.largest_buffer());
        assert!(plan.largest_buffer() <= limit, "{} of {limit}", plan.largest_buffer());
        for bytes in [POINT_BYTES, DIFFUSE_BYTES, SPECULAR_BYTES, NEAR_BYTES] {
            assert!(plan.capacity() * bytes <= plan.largest_buffer());
        }
        assert!(plan.sample_size[0] <= limits.max_texture_dimension_2d);
        // Materials are a storage buffer, too.
        assert!(7 < limits.max_storage_buffers_per_shader_stage);
    }

    #[test]
    fn blocks_divide_pixels() {
        for supersample in 1..=8 {
            let techniques = TechniqueSettings { supersample, ..Default::default() };
            let planes = SumPlanes { specular: false, near: false, wide: false, evened: false };
            let plan = PointPlan::new(&techniques, [8, 8], planes);
            for (_, stage) in plan.stages() {
                assert!(supersample % stage.block == 0 && stage.block <= supersample, "{stage:?}");
            }
        }
    }
}
