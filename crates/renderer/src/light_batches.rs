//! The frame's lights in batches, each with what its shadow technique keeps for it.

use glam::Vec3;
use gnomon_scene::PlacedLight;
use gnomon_shaders::layout;

use crate::batch_plan::{Budget, Class, LightNeeds, plan};
use crate::gbuffer::GBuffer;
use crate::geometry::Geometry;
use crate::light_pass::{self, LightPass};
use crate::light_points::PointsOfLights;
use crate::light_uniforms::{FittedLights, FrameLight, LightFitting, frame_lights, sum_scales};
use crate::lighting::Lighting;
use crate::materials::Materials;
use crate::ray_scene::RayScene;
use crate::recorder::Recorder;
use crate::shading_points::{PointStage, ShadingPoints};
use crate::shadow::depth_maps::DepthMaps;
use crate::shadow::technique::{
    BatchSize, FrameInputs, FrameLights, RayTargets, ShadowContext, ShadowResources, ShadowTechnique,
    SharedPasses,
};
use crate::view_slices::ViewSlices;
use crate::{Gpu, RenderError, TechniqueSettings};

/// All lights of a frame in batches, planned for a number of shading points.
pub(crate) struct LightBatches {
    classes: Vec<ClassShadows>,
    batches: Vec<Batch>,
    bytes: u64,
    /// Room for shading points that was planned for; `None` where it makes no difference.
    points: Option<u64>,
    fitting: LightFitting,
    /// Places in the frame's list of lights that shine on each slice of the view by themselves.
    sliced: Vec<usize>,
    /// How many slices are planned for, and those that lights are fitted to.
    slice_count: usize,
    slices: ViewSlices,
    sum_scales: Vec3,
    /// Of each light by its place, which layer it is part of.
    groups: Vec<u32>,
    /// Of all lights, where rays go to them.
    points_of_lights: Option<PointsOfLights>,
    /// Whether lights, scene or pose are others than those that batches are fitted to.
    is_stale: bool,
    /// Whether they were fitted anew for the frame, or band of one, that comes next.
    is_refitted: bool,
}

/// What batches of one class use in turn.
struct ClassShadows {
    needs: LightNeeds,
    shadows: Box<dyn ShadowResources>,
}

/// Lights whose shadows are held together.
pub(crate) struct Batch {
    class: usize,
    /// Lights by their place in the frame's list.
    members: Vec<usize>,
    fitted: FittedLights,
    /// [`layout::Light`] of each member.
    pub lights: wgpu::Buffer,
    /// A [`layout::Batch`].
    pub parameters: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    lights_group: wgpu::BindGroup,
}

/// What batches are made with.
pub(crate) struct BatchContext<'a> {
    pub gpu: &'a Gpu,
    pub shared: &'a SharedPasses,
    pub technique: &'static dyn ShadowTechnique,
    pub settings: &'a TechniqueSettings,
    pub view: &'a wgpu::Buffer,
    /// Where the technique traces rays.
    pub ray_scene: Option<&'a RayScene>,
    /// Module for slot `bumps`.
    pub bumps: &'static str,
}

/// What a frame's light is summed of.
#[derive(Clone, Copy)]
pub(crate) struct LitScene<'a> {
    pub geometry: &'a Geometry,
    pub materials: &'a Materials,
    /// What the camera sees, and the bind group of its view.
    pub seen: &'a GBuffer,
    pub view: &'a wgpu::BindGroup,
    pub points: &'a ShadingPoints,
    /// Of the bands of a picture.
    pub is_first_band: bool,
    /// Of what is lit in a band, layer after layer: the maps of others are those of the first.
    pub is_first_layer: bool,
}

impl LightBatches {
    /// Batches for the lights of `lighting` and the scene, summed at points with so much room, in a view of so many slices.
    ///
    /// # Errors
    /// [`RenderError::OverBudget`] or [`RenderError::OverLimit`] where not even one light fits, [`RenderError::OutOfRange`] for a setting of the
    /// technique.
    pub fn new(
        context: &BatchContext<'_>,
        lighting: &Lighting,
        near_lights: &[PlacedLight],
        (points, slice_count): (u64, usize),
    ) -> Result<Self, RenderError> {
        let BatchContext { gpu, shared, technique, settings, view, ray_scene, bumps } = *context;
        let shadow_settings = &settings.shadow_settings;
        // What is decided by the lights' sizes does not change as the environment turns.
        let mut all = frame_lights(lighting.fitted(), lighting, near_lights);
        let total_flux = all.iter().map(FrameLight::flux).sum();
        let sliced: Vec<usize> = (0..all.len())
            .filter(|&place| technique.has_sharp_maps() && all[place].is_sharp(total_flux))
            .collect();
        add_slices(&mut all, &sliced, slice_count);
        let needs: Vec<LightNeeds> =
            all.iter().map(|light| light.needs(technique, settings, total_flux)).collect();
        let memory = |needs: LightNeeds| technique.memory(shadow_settings, needs.resolution);
        let bytes_per_light = |needs| memory(needs).per_light + memory(needs).per_pair * points;
        let most_lights = |needs| {
            let layers = technique.layers_per_light(shadow_settings);
            let by_layers = gpu.max_layers().checked_div(layers).unwrap_or(u32::MAX);
            let bytes = memory(needs).per_pair * points;
            let by_bytes = gpu.largest_storage().checked_div(bytes).unwrap_or(u64::MAX);
            by_layers.min(layout::MAX_BATCH_LIGHTS).min(by_bytes.try_into().unwrap_or(u32::MAX))
        };
        let mut planned = plan(
            &needs,
            &Budget {
                bytes_per_light: &bytes_per_light,
                bytes: u64::from(settings.shadow_memory) << 20,
                most_lights: &most_lights,
                adapter: &gpu.adapter().name,
            },
        )?;
        if planned.first().is_none_or(|class| class.needs.points > 0) {
            // Without lights on the first list there is still one pass, which clears its sums.
            let needs = LightNeeds { points: 0, resolution: 1 };
            planned.insert(0, Class { needs, capacity: 0, batches: vec![Vec::new()] });
        }

        let bytes =
            planned.iter().map(|class| u64::from(class.capacity) * bytes_per_light(class.needs)).sum();
        let by_pair = planned.iter().any(|class| memory(class.needs).per_pair > 0);
        let points_of_lights = ray_scene.map(|_| PointsOfLights::new(gpu, all.len()));
        let rays = ray_scene.zip(points_of_lights.as_ref());
        let rays = rays.map(|(scene, points)| RayTargets { scene, light_points: &points.view });
        let mut classes = Vec::with_capacity(planned.len());
        let mut batches: Vec<Batch> = Vec::new();
        for (index, class) in planned.into_iter().enumerate() {
            let LightNeeds { resolution, .. } = class.needs;
            let size = BatchSize { lights: class.capacity, resolution, points };
            let context = ShadowContext { gpu, settings: shadow_settings, shared, size, rays, bumps };
            let shadows = technique.resources(&context)?;
            classes.push(ClassShadows { needs: class.needs, shadows });
            for members in class.batches {
                let is_first = batches.is_empty();
                batches.push(Batch::new(gpu, shared, view, (index, members), is_first));
            }
        }
        Ok(Self {
            classes,
            batches,
            bytes,
            points: by_pair.then_some(points),
            fitting: LightFitting::new(technique, settings),
            sliced,
            slice_count,
            slices: ViewSlices::default(),
            sum_scales: Vec3::ONE,
            groups: Vec::new(),
            points_of_lights,
            is_stale: true,
            is_refitted: false,
        })
    }

    /// What sums of light are multiplied by to be kept in halves ([`layout::View::sum_scales`]).
    pub fn sum_scales(&self) -> Vec3 {
        self.sum_scales
    }

    /// The first list of points that any light is summed at.
    pub fn first_list(&self) -> usize {
        self.classes.iter().map(|class| class.needs.points).min().unwrap_or(0)
    }

    /// Whether the plan holds for so much room for points and so many slices of the view.
    pub fn is_planned_for(&self, points: u64, slice_count: usize) -> bool {
        let has_slices = self.sliced.is_empty() || slice_count <= self.slice_count;
        has_slices && self.points.is_none_or(|planned| (points..=2 * points).contains(&planned))
    }

    /// GPU memory of what the technique keeps, in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Number of batches.
    pub fn len(&self) -> usize {
        self.batches.len()
    }

    /// Layout of the technique's bind group, the same for every class.
    pub fn shadow_layout(&self) -> Option<&wgpu::BindGroupLayout> {
        self.classes.first().map(|class| class.shadows.layout())
    }

    /// Number of lights, each counted once.
    pub fn light_count(&self) -> usize {
        self.sizes().sum::<u32>() as usize - (self.slice_count - 1) * self.sliced.len()
    }

    /// Number of lights in every batch.
    pub fn sizes(&self) -> impl Iterator<Item = u32> {
        self.batches.iter().map(|batch| batch.members.len() as u32)
    }

    /// Batch of a light of the frame's list, and its place there.
    pub fn place_of(&self, light: usize) -> Option<(usize, u32)> {
        let place = |batch: &Batch| batch.members.iter().position(|&member| member == light);
        self.batches.iter().enumerate().find_map(|(i, batch)| Some((i, place(batch)? as u32)))
    }

    /// [`layout::Light`]s of every batch, and their depth maps where there are any.
    pub fn lights_and_maps(&self) -> impl Iterator<Item = (&wgpu::Buffer, Option<&DepthMaps>)> {
        self.batches.iter().map(|batch| (&batch.lights, self.classes[batch.class].shadows.depth_maps()))
    }

    /// Sums all lights of every batch, or only one of the frame's list.
    pub fn sum_only(&mut self, gpu: &Gpu, only: Option<usize>) {
        let only = only.map(|light| self.place_of(light));
        for (i, batch) in self.batches.iter().enumerate() {
            let (first, end) = match only {
                None => (0, batch.members.len() as u32),
                Some(Some((chosen, light))) if chosen == i => (light, light + 1),
                Some(_) => (0, 0),
            };
            gpu.write(&batch.parameters, &Batch::parameters(first, end, i == 0));
        }
        self.is_stale = true;
    }

    /// Lets the light of one group through from the next submission on, or that of all.
    pub fn show_group(&self, gpu: &Gpu, group: Option<u32>) {
        for (i, batch) in self.batches.iter().enumerate() {
            let all = Batch::parameters(0, batch.members.len() as u32, i == 0);
            let group = group.unwrap_or(layout::ALL_GROUPS);
            gpu.write(&batch.parameters, &layout::Batch { group, ..all });
        }
    }

    /// Lights, scene or pose are others from now on.
    pub fn refit(&mut self) {
        self.is_stale = true;
    }

    /// Fits every light around the scene as it stands and what is seen of it, unless nothing has moved since.
    pub fn fit(
        &mut self,
        gpu: &Gpu,
        (lighting, near_lights): (&Lighting, &[PlacedLight]),
        (geometry, slices): (&Geometry, ViewSlices),
        (only, groups): (Option<usize>, &[u32]),
    ) {
        let moved = !self.sliced.is_empty() && self.slices != slices;
        let regrouped = self.groups != groups;
        self.is_refitted = std::mem::take(&mut self.is_stale) || moved || regrouped;
        if !self.is_refitted {
            return;
        }
        self.slices = slices;
        self.groups = groups.to_vec();
        let mut all = frame_lights([&lighting.lights, &lighting.probes], lighting, near_lights);
        let unsliced = all.len();
        add_slices(&mut all, &self.sliced, self.slice_count);
        for batch in &mut self.batches {
            let LightNeeds { resolution, .. } = self.classes[batch.class].needs;
            batch.fitted = self.fitting.fit(&all, &batch.members, resolution, (geometry, &self.slices), only);
            for uniform in &mut batch.fitted.uniforms {
                let place = uniform.number as usize;
                // What is behind all lights shines on further slices.
                let light = match place.checked_sub(unsliced) {
                    Some(slice) => self.sliced[slice % self.sliced.len()],
                    None => place,
                };
                uniform.group = groups.get(light).copied().unwrap_or_default();
            }
            gpu.write(&batch.lights, batch.fitted.uniforms.as_slice());
        }
        if let Some(points) = &self.points_of_lights {
            points.write(gpu, &all, self.fitting.rays);
        }
        // No point has the light of more than one slice: a picture does not depend on how many there were before it.
        let uniforms = self.batches.iter().flat_map(|batch| &batch.fitted.uniforms);
        self.sum_scales = sum_scales(uniforms.filter(|uniform| (uniform.number as usize) < unsliced));
    }

    /// Makes what visibility needs, and sums light at the points of a stage, batch after batch.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        light: &LightPass,
        scene: LitScene<'_>,
        stage: &PointStage,
    ) -> Result<(), RenderError> {
        for batch in self.batches.iter().filter(|batch| self.classes[batch.class].needs.points == stage.list)
        {
            let frame = self.frame(batch, scene, stage);
            let shadows = &self.classes[batch.class].shadows;
            shadows.prepare(recorder, &frame)?;
            light.encode(recorder, [frame.frame, frame.gbuffer, shadows.bind_group()], scene.points, stage);
            recorder.end_pass("light")?;
        }
        Ok(())
    }

    /// Sums the light of a group, which [`LightBatches::show_group`] has let through, at the points of a stage that is listed. Unshadowed light is
    /// that of all lights.
    pub fn encode_group(
        &self,
        recorder: &mut Recorder<'_>,
        light: &LightPass,
        scene: LitScene<'_>,
        (stage, group): (&PointStage, u32),
    ) -> Result<(), RenderError> {
        let of_list = |batch: &&Batch| self.classes[batch.class].needs.points == stage.list;
        for batch in self.batches.iter().filter(of_list) {
            let shadows = &self.classes[batch.class].shadows;
            let frame = self.frame(batch, scene, stage);
            if batch.fitted.uniforms.iter().any(|light| light.group == group) {
                shadows.prepare(recorder, &frame)?;
            }
            light.encode(recorder, [frame.frame, frame.gbuffer, shadows.bind_group()], scene.points, stage);
        }
        Ok(())
    }

    /// Whether another batch of its class takes the place of its shadows.
    fn takes_turns(&self, batch: &Batch) -> bool {
        self.batches.iter().filter(|other| other.class == batch.class).count() > 1
    }

    /// Makes what visibility of one batch needs once more: another batch of its class may have taken its place.
    pub fn prepare_again(
        &self,
        recorder: &mut Recorder<'_>,
        scene: LitScene<'_>,
        batch: usize,
    ) -> Result<(), RenderError> {
        let (Some(batch), Some(stage)) = (self.batches.get(batch), scene.points.stages.first()) else {
            return Ok(());
        };
        self.classes[batch.class].shadows.prepare(recorder, &self.frame(batch, scene, stage))
    }

    /// The frame as the technique sees it for a batch.
    fn frame<'a>(&'a self, batch: &'a Batch, scene: LitScene<'a>, stage: &'a PointStage) -> FrameInputs<'a> {
        let is_stale =
            scene.is_first_layer && stage.lists_tiles() && (scene.is_first_band || self.is_refitted);
        FrameInputs {
            geometry: scene.geometry,
            materials: scene.materials,
            frame: &batch.frame_group,
            gbuffer: &scene.seen.group,
            seen: scene.seen,
            view: scene.view,
            points: scene.points,
            stage,
            lights: FrameLights {
                uniforms: &batch.fitted.uniforms,
                casters: &batch.fitted.casters,
                group: &batch.lights_group,
            },
            same_lights: !(self.takes_turns(batch) || is_stale),
        }
    }
}

/// Has some lights of a frame's list shine on the first slice only, and adds them for the others.
fn add_slices(all: &mut Vec<FrameLight<'_>>, sliced: &[usize], slice_count: usize) {
    for &place in sliced {
        all[place] = all[place].for_slice(0);
    }
    for slice in 1..slice_count {
        let of_slice: Vec<_> = sliced.iter().map(|&place| all[place].for_slice(slice)).collect();
        all.extend(of_slice);
    }
}

impl Batch {
    fn new(
        gpu: &Gpu,
        shared: &SharedPasses,
        view: &wgpu::Buffer,
        (class, members): (usize, Vec<usize>),
        is_first: bool,
    ) -> Self {
        let lights = gpu.empty_buffer(
            "lights",
            layout::size::<layout::Light>() * u64::from(layout::MAX_BATCH_LIGHTS),
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        );
        let parameters = Self::parameters(0, members.len() as u32, is_first);
        let parameters = gpu.shared_buffer("batch", &parameters, wgpu::BufferUsages::UNIFORM);
        Self {
            class,
            members,
            fitted: FittedLights::default(),
            frame_group: light_pass::frame_group(gpu, &shared.frame, view, [&lights, &parameters]),
            lights_group: shared.shadow_map.lights_group(gpu, &lights),
            lights,
            parameters,
        }
    }

    fn parameters(first_light: u32, end_light: u32, first: bool) -> layout::Batch {
        let flags = if first { layout::FLAG_FIRST } else { 0 };
        layout::Batch { first_light, end_light, flags, group: layout::ALL_GROUPS }
    }
}
