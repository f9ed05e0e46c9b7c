use gnomon_lights::DistantLight;
use gnomon_scene::PlacedLight;
use gnomon_shaders::layout;

use crate::batch_plan::{Budget, plan};
use crate::casters::Casters;
use crate::depth_maps::{DepthMaps, MapView, ShadowMapPass};
use crate::geometry::Geometry;
use crate::light_frame::{footprint, hidden_deviation, light_uniform};
use crate::light_pass::{self, LightPass};
use crate::lighting::Lighting;
use crate::near_light_frame::near_light_uniform;
use crate::recorder::Recorder;
use crate::shading_points::ShadingPoints;
use crate::shadow::{ShadowResources, ShadowTechnique};
use crate::{Gpu, RenderError, RenderSettings};

/// All lights of a frame in batches, and the shadow maps that the batches use in turn.
pub(crate) struct ShadowBatches {
    classes: Vec<ClassMaps>,
    batches: Vec<Batch>,
    bytes: u64,
    technique: &'static dyn ShadowTechnique,
    caster_deviation_texels: f32,
}

/// Maps of one size, for as many lights as a batch has.
struct ClassMaps {
    depth_maps: DepthMaps,
    shadows: Box<dyn ShadowResources>,
}

/// Lights whose maps are held together.
pub(crate) struct Batch {
    class: usize,
    /// Lights by their place in the frame's list.
    members: Vec<usize>,
    /// [`layout::Light`] of each member.
    pub lights: wgpu::Buffer,
    /// A [`layout::Batch`].
    pub parameters: wgpu::Buffer,
    lights_group: wgpu::BindGroup,
}

/// A light of the frame: the environment's, its probes, the scene's own.
#[derive(Clone, Copy)]
enum Member<'a> {
    Distant { light: &'a DistantLight, role: u32 },
    Near(&'a PlacedLight),
}

fn members<'a>(
    [lights, probes]: [&'a [DistantLight]; 2],
    near: &'a [PlacedLight],
) -> impl Iterator<Item = Member<'a>> {
    let with = |role| move |light| Member::Distant { light, role };
    let lights = lights.iter().map(with(layout::ROLE_LIGHT));
    let probes = probes.iter().map(with(layout::ROLE_PROBE));
    lights.chain(probes).chain(near.iter().map(Member::Near))
}

impl ShadowBatches {
    /// Maps and buffers for the lights of `lighting`.
    pub fn new(
        gpu: &Gpu,
        pass: &ShadowMapPass,
        technique: &'static dyn ShadowTechnique,
        settings: &RenderSettings,
        lighting: &Lighting,
        near_lights: &[PlacedLight],
    ) -> Result<Self, RenderError> {
        let with_maps = technique.needs_depth_maps();
        let all: Vec<Member<'_>> = members(lighting.fitted(), near_lights).collect();
        let resolution = |member: &Member<'_>| match member {
            _ if !with_maps => 1,
            Member::Distant { light, .. } => settings
                .techniques
                .shadow_sizing
                .resolution(footprint(light), settings.techniques.shadow_resolution),
            Member::Near(_) => settings.techniques.shadow_resolution,
        };
        let resolutions: Vec<u32> = all.iter().map(resolution).collect();
        let bytes_per_light = |resolution| match with_maps {
            true => {
                DepthMaps::bytes_per_light(resolution)
                    + technique.bytes_per_light(&settings.techniques.shadow_settings, resolution)
            }
            false => 0,
        };
        let lights_per_class = match with_maps {
            true => {
                gpu.max_layers() / technique.layers_per_light(&settings.techniques.shadow_settings).max(1)
            }
            false => u32::MAX,
        };
        let lights_per_class = lights_per_class.min(layout::MAX_BATCH_LIGHTS);
        let mut planned = plan(
            &resolutions,
            &Budget {
                bytes_per_light: &bytes_per_light,
                bytes: u64::from(settings.techniques.shadow_memory) << 20,
                lights_per_class,
                adapter: &gpu.adapter().name,
            },
        )?;
        if planned.is_empty() {
            // Without lights there is still one pass, which clears the sums.
            planned.push(crate::batch_plan::Class { resolution: 1, capacity: 0, batches: vec![Vec::new()] });
        }

        let bytes = planned.iter().map(|c| u64::from(c.capacity) * bytes_per_light(c.resolution)).sum();
        let mut classes = Vec::with_capacity(planned.len());
        let mut batches: Vec<Batch> = Vec::new();
        for (index, class) in planned.into_iter().enumerate() {
            let maps = if with_maps { class.capacity } else { 0 };
            let depth_maps = DepthMaps::new(gpu, maps, class.resolution);
            let shadows = technique.resources(gpu, &settings.techniques.shadow_settings, &depth_maps)?;
            classes.push(ClassMaps { depth_maps, shadows });
            for members in class.batches {
                let place = batches.len();
                batches.push(Batch::new(gpu, pass, index, members, place == 0));
            }
        }
        Ok(Self {
            classes,
            batches,
            bytes,
            technique,
            caster_deviation_texels: settings.techniques.caster_deviation,
        })
    }

    /// GPU memory of all maps and images in bytes.
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

    /// Bind group of the frame for every batch.
    pub fn frame_groups(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view: &wgpu::Buffer,
    ) -> Vec<wgpu::BindGroup> {
        self.batches.iter().map(|batch| light_pass::frame_group(gpu, layout, view, batch)).collect()
    }

    /// Number of lights.
    pub fn light_count(&self) -> usize {
        self.sizes().sum::<u32>() as usize
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

    /// [`layout::Light`]s and depth maps of every batch.
    pub fn lights_and_maps(&self) -> impl Iterator<Item = (&wgpu::Buffer, &DepthMaps)> {
        self.batches.iter().map(|batch| (&batch.lights, &self.classes[batch.class].depth_maps))
    }

    /// Sums all lights of every batch, or only one of the frame's list.
    pub fn sum_only(&self, gpu: &Gpu, only: Option<usize>) {
        let only = only.map(|light| self.place_of(light));
        for (i, batch) in self.batches.iter().enumerate() {
            let (first, end) = match only {
                None => (0, batch.members.len() as u32),
                Some(Some((chosen, light))) if chosen == i => (light, light + 1),
                Some(_) => (0, 0),
            };
            let parameters = Batch::parameters(first, end, i == 0);
            gpu.write(&batch.parameters, &parameters);
        }
    }

    /// Fits every light's map around the scene as it stands in this frame, and tells batch by batch what the maps show. The light `only` counts as
    /// a probe, which tells its visibility.
    pub fn write_lights(
        &self,
        gpu: &Gpu,
        lighting: &Lighting,
        near_lights: &[PlacedLight],
        geometry: &Geometry,
        normal_offset_texels: f32,
        only: Option<usize>,
    ) -> Vec<Vec<MapView>> {
        let (scene, end) = (&geometry.placed_boxes, geometry.index_count);
        let all: Vec<Member<'_>> = members([&lighting.lights, &lighting.probes], near_lights).collect();
        let of_batch = |batch: &Batch| {
            let resolution = self.classes[batch.class].depth_maps.resolution;
            let fitted = batch.members.iter().map(|&place| {
                let (mut uniform, casters) = match all[place] {
                    Member::Distant { light, role } => {
                        let uniform = light_uniform(light, scene, resolution, normal_offset_texels);
                        let casters = self.casters(light, &uniform, resolution);
                        (layout::Light { role, ..uniform }, casters)
                    }
                    Member::Near(light) => {
                        let uniform = near_light_uniform(light, scene, resolution, normal_offset_texels);
                        (uniform, Casters::default())
                    }
                };
                let drawn = scene.casters(&casters, end);
                uniform.caster_deviation_world = drawn.deviation_world;
                if only == Some(place) {
                    uniform.role = layout::ROLE_PROBE;
                }
                let is_perspective = matches!(all[place], Member::Near(_));
                (uniform, MapView { is_perspective, indices: drawn.indices })
            });
            let (lights, views): (Vec<layout::Light>, Vec<MapView>) = fitted.unzip();
            gpu.write(&batch.lights, lights.as_slice());
            views
        };
        self.batches.iter().map(of_batch).collect()
    }

    fn casters<'a>(&self, light: &'a DistantLight, uniform: &layout::Light, resolution: u32) -> Casters<'a> {
        let deviation_world = hidden_deviation(light, uniform, resolution, self.caster_deviation_texels);
        Casters { above: (!self.technique.draws_grounds()).then_some(light), deviation_world }
    }

    /// Draws and filters maps and sums light batch after batch. Another band of a picture finds the maps as the first one left them, but for
    /// those of batches that take turns.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        passes: (&ShadowMapPass, &LightPass),
        (geometry, views): (&Geometry, &[Vec<MapView>]),
        frame_groups: &[wgpu::BindGroup],
        (gbuffer_group, points): (&wgpu::BindGroup, &ShadingPoints),
        is_first_band: bool,
    ) -> Result<(), RenderError> {
        let (shadow_map, light) = passes;
        for ((batch, frame_group), views) in self.batches.iter().zip(frame_groups).zip(views) {
            let class = &self.classes[batch.class];
            let takes_turns = self.batches.iter().filter(|other| other.class == batch.class).count() > 1;
            let needs_maps = is_first_band || takes_turns;
            if needs_maps {
                self.draw_maps(recorder, shadow_map, (geometry, views), batch);
            }
            recorder.end_pass("shadow maps")?;
            if needs_maps {
                class.shadows.encode(recorder, class.depth_maps.capacity.min(batch.members.len() as u32));
            }
            recorder.end_pass("shadow filter")?;
            light.encode(recorder, [frame_group, gbuffer_group, class.shadows.bind_group()], points);
            recorder.end_pass("light")?;
        }
        Ok(())
    }

    /// Draws the depth maps of a batch once more: another batch with maps of that size may have taken their place.
    pub fn draw_maps_again(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &ShadowMapPass,
        (geometry, views): (&Geometry, &[Vec<MapView>]),
        batch: usize,
    ) {
        if let (Some(batch), Some(views)) = (self.batches.get(batch), views.get(batch)) {
            self.draw_maps(recorder, pass, (geometry, views), batch);
        }
    }

    fn draw_maps(
        &self,
        recorder: &mut Recorder<'_>,
        pass: &ShadowMapPass,
        (geometry, views): (&Geometry, &[MapView]),
        batch: &Batch,
    ) {
        let maps = &self.classes[batch.class].depth_maps;
        pass.encode(recorder, geometry, maps, &batch.lights_group, views);
    }
}

impl Batch {
    fn new(gpu: &Gpu, pass: &ShadowMapPass, class: usize, members: Vec<usize>, first: bool) -> Self {
        let lights = gpu.empty_buffer(
            "lights",
            layout::size::<layout::Light>() * u64::from(layout::MAX_BATCH_LIGHTS),
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        );
        let parameters = Self::parameters(0, members.len() as u32, first);
        let parameters = gpu.shared_buffer("batch", &parameters, wgpu::BufferUsages::UNIFORM);
        let lights_group = pass.lights_group(gpu, &lights);
        Self { class, members, lights, parameters, lights_group }
    }

    fn parameters(first_light: u32, end_light: u32, first: bool) -> layout::Batch {
        let flags = if first { layout::FLAG_FIRST } else { 0 };
        layout::Batch { first_light, end_light, flags }
    }
}
