use std::ops::Range;
use std::sync::Arc;

use glam::{Quat, Vec3, Vec4};
use gnomon_envmap::{Backdrop, Equirect, Grade, PrefilteredMap, Sh9};
use gnomon_lights::{DistantLight, LightSet};
use gnomon_picture::RgbImage;
use gnomon_shaders::layout;

use crate::ambient::{self, Ambient, AmbientLights};
use crate::irradiance::Irradiance;
use crate::light_points::{self, LightPoints};
use crate::{Gpu, RenderError, RenderSettings, sky_samples};

/// Texels along the side of the environment BRDF's table; the outermost ones stand for 0 and 1.
const DFG_SIZE: u32 = 32;
/// Width of the sharpest prefiltered level, and number of levels.
const PREFILTERED_WIDTH: u32 = 512;
const PREFILTERED_LEVELS: u32 = 6;

/// An environment worked out for a renderer: lights, coefficients, filtered maps. Takes a second for a large map, and no device: make it
/// on any thread and hand it to [`crate::Renderer::set_prepared_lighting`].
pub struct PreparedLighting {
    pub(crate) ambient: &'static Ambient,
    pub(crate) ambient_cells: usize,
    lights: Vec<DistantLight>,
    of_fit: usize,
    probes: Vec<DistantLight>,
    residual: Equirect,
    omits_hidden: bool,
    stands_alone: bool,
    taken_out: usize,
    points: Arc<[LightPoints]>,
    map: Arc<Equirect>,
    peak: f32,
    full_sh: [Vec4; 9],
    background: Vec<Equirect>,
    backdrop: Option<Arc<Backdrop>>,
    seen: Option<Equirect>,
    irradiance: Irradiance,
    prefiltered_full: Vec<Equirect>,
    rest: PreparedRest,
}

/// What is made of the ambient rest.
struct PreparedRest {
    sh: [Vec4; 9],
    prefiltered: Vec<Equirect>,
}

impl PreparedLighting {
    /// `map` is what the camera sees and mirrors reflect, unless `set` stands alone; `set` is how it casts light and shadow; of the settings, those of the ambient
    /// rest count.
    ///
    /// # Errors
    /// [`RenderError::UnknownName`] or [`RenderError::OutOfRange`] for what the settings say of the ambient rest.
    pub fn new(map: &Equirect, set: &LightSet, settings: &RenderSettings) -> Result<Self, RenderError> {
        let (method, ambient_cells) =
            (ambient::by_name(&settings.lighting.ambient)?, settings.lighting.ambient_cells);
        let ambient = method.lights(set, ambient_cells)?;
        let of_cells = points_of_cells(&ambient, map);
        Ok(Self {
            ambient: method,
            ambient_cells,
            peak: map.radiance().texels().iter().fold(0.0, |peak, texel| texel.max_element().max(peak)),
            full_sh: spherical_harmonics(map),
            background: mip_levels(map),
            backdrop: map.backdrop().cloned(),
            irradiance: Irradiance::new(map),
            prefiltered_full: prefiltered(map),
            rest: PreparedRest::new(&ambient.residual),
            residual: ambient.residual,
            omits_hidden: ambient.omits_hidden,
            stands_alone: ambient.stands_alone,
            taken_out: ambient.taken_out,
            seen: None,
            points: of_cells,
            map: Arc::new(light_points::source(map)),
            lights: ambient.lights,
            of_fit: ambient.of_fit,
            probes: ambient.probes,
        })
    }

    /// The same with a map that mirrors show in place of the whole one: what the last lights of the set hold is taken out of it
    /// ([`LightSet::taken_out`]).
    #[must_use]
    pub fn with_mirrored(self, map: &Equirect) -> Self {
        Self { background: mip_levels(map), prefiltered_full: prefiltered(map), ..self }
    }

    /// The same with another map behind the scene, which lights nothing.
    #[must_use]
    pub fn with_background(self, map: Equirect) -> Self {
        Self { seen: Some(map), ..self }
    }
}

impl PreparedRest {
    fn new(residual: &Equirect) -> Self {
        // A fit that leaves nothing, or an ambient rest that became lights: nothing to filter.
        let is_black = residual.radiance().texels().iter().all(|texel| *texel == Vec3::ZERO);
        let prefiltered = match is_black {
            true => vec![Equirect::new(RgbImage::filled(2, 1, Vec3::ZERO))],
            false => prefiltered(residual),
        };
        Self { sh: spherical_harmonics(residual), prefiltered }
    }
}

/// An environment ready to light frames: lights on the CPU, maps on the GPU. Independent of any scene.
#[derive(Clone)]
pub(crate) struct Lighting {
    /// Lights as the environment is turned and graded.
    pub lights: Vec<DistantLight>,
    /// So many of them are the fit's; the others are its ambient rest.
    pub of_fit: usize,
    /// So many of these, the last ones, are not in the map that is mirrored.
    taken_out: usize,
    /// Lights that only tell how much of the sky is open, as the environment is turned.
    pub probes: Vec<DistantLight>,
    /// Lights and probes in the environment's own frame, not graded. Nothing that is made of it is, nor are the maps.
    fitted: [Vec<DistantLight>; 2],
    /// How it is graded.
    grade: Grade,
    /// What stays ambient, and what is made of it.
    residual: Arc<Equirect>,
    /// Whether light that arrives nowhere is left out, and whether the lights are no fit's: unshadowed light is then theirs.
    pub omits_hidden: bool,
    pub stands_alone: bool,
    /// The environment, as far as its lights' points ask for it.
    map: Arc<Equirect>,
    /// Largest component of its radiance.
    peak: f32,
    /// Where the light of each of the lights comes from, in its own frame, where they stand for the parts of the map that they cover.
    pub points: Arc<[LightPoints]>,
    residual_sh: [Vec4; 9],
    full_sh: [Vec4; 9],
    /// The environment with mip levels.
    pub background: wgpu::TextureView,
    /// What is behind the scene, and the radiance of a 1 in there.
    pub seen: wgpu::TextureView,
    seen_scale: f32,
    /// [`layout::Emitters`] of the whole environment, and the irradiance of all else over the sphere of normals.
    pub emitters: wgpu::Buffer,
    pub irradiance_rest: wgpu::TextureView,
    pub prefiltered_full: wgpu::TextureView,
    pub prefiltered_residual: wgpu::TextureView,
    pub dfg_table: wgpu::TextureView,
}

impl Lighting {
    pub fn new(gpu: &Gpu, prepared: PreparedLighting) -> Result<Self, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let maps = prepared.background.iter().chain(&prepared.seen);
        let sides = maps.flat_map(|map| [map.width(), map.height()]);
        let largest = sides.max().unwrap_or(0);
        if largest > limit {
            return Err(RenderError::OverLimit {
                what: "texels along the environment's side",
                wanted: u64::from(largest),
                limit: u64::from(limit),
                adapter: gpu.adapter().name.clone(),
            });
        }
        let background = upload_maps(gpu, "background", &prepared.background);
        let backdrop = prepared.seen.as_ref().map_or(prepared.backdrop, |seen| seen.backdrop().cloned());
        let (seen, seen_scale) = match (backdrop, prepared.seen) {
            (Some(backdrop), _) => upload_backdrop(gpu, backdrop),
            (None, Some(seen)) => (upload_maps(gpu, "seen", &[seen]), 1.0),
            (None, None) => (background.clone(), 1.0),
        };
        let unit = |i: u32| i as f32 / (DFG_SIZE - 1) as f32;
        let dfg =
            RgbImage::from_fn(DFG_SIZE, DFG_SIZE, |x, y| gnomon_brdf::dfg(unit(x), unit(y)).extend(0.0));
        Ok(Self {
            lights: prepared.lights.clone(),
            of_fit: prepared.of_fit,
            taken_out: prepared.taken_out,
            probes: prepared.probes.clone(),
            fitted: [prepared.lights, prepared.probes],
            grade: Grade::NONE,
            omits_hidden: prepared.omits_hidden,
            stands_alone: prepared.stands_alone,
            points: prepared.points,
            map: prepared.map,
            peak: prepared.peak,
            residual_sh: prepared.rest.sh,
            full_sh: prepared.full_sh,
            background,
            seen,
            seen_scale,
            emitters: upload_emitters(gpu, &prepared.irradiance.emitters),
            irradiance_rest: upload(gpu, "irradiance", &[prepared.irradiance.rest]),
            prefiltered_full: upload_maps(gpu, "prefiltered", &prepared.prefiltered_full),
            prefiltered_residual: upload_maps(gpu, "prefiltered", &prepared.rest.prefiltered),
            residual: Arc::new(prepared.residual),
            dfg_table: upload(gpu, "dfg", &[dfg]),
        })
    }

    /// The same environment with other lights. Maps are made only where another part of it stays ambient.
    pub fn with_lights(self, gpu: &Gpu, ambient: AmbientLights) -> Self {
        let lit = Self {
            points: points_of_cells(&ambient, &self.map),
            lights: ambient.lights.clone(),
            of_fit: ambient.of_fit,
            taken_out: ambient.taken_out,
            probes: ambient.probes.clone(),
            fitted: [ambient.lights, ambient.probes],
            omits_hidden: ambient.omits_hidden,
            stands_alone: ambient.stands_alone,
            ..self
        };
        if *lit.residual == ambient.residual {
            return lit;
        }
        let rest = PreparedRest::new(&ambient.residual);
        Self {
            residual_sh: rest.sh,
            prefiltered_residual: upload_maps(gpu, "prefiltered", &rest.prefiltered),
            residual: Arc::new(ambient.residual),
            ..lit
        }
    }

    /// Turns lights and probes, and grades the lights; the maps are turned and graded where they are looked up.
    pub fn set(&mut self, world_from_environment: Quat, grade: Grade) {
        let [lights, probes] = &self.fitted;
        let turned = |lights: &[DistantLight]| match world_from_environment == Quat::IDENTITY {
            // To the last bit as they were fitted.
            true => lights.to_vec(),
            false => lights.iter().map(|light| light.turned(world_from_environment)).collect(),
        };
        (self.lights, self.probes) = (turned(lights), turned(probes));
        if grade.light != Vec3::ONE {
            self.lights.iter_mut().for_each(|light| *light = light.times(grade.light));
        }
        self.grade = grade;
    }

    /// Factor of what is looked up in the maps that light.
    pub fn factor(&self) -> Vec3 {
        self.grade.light
    }

    /// Radiance of a 1 in [`Lighting::seen`].
    pub fn background_factor(&self) -> Vec3 {
        self.seen_scale * self.grade.background
    }

    /// Largest component of the environment's radiance.
    pub fn peak(&self) -> f32 {
        self.peak * self.grade.light.max_element()
    }

    /// SH coefficients of the residual and of the whole environment.
    pub fn spherical_harmonics(&self) -> [[Vec4; 9]; 2] {
        let factor = self.grade.light.extend(1.0);
        [self.residual_sh, self.full_sh].map(|coefficients| coefficients.map(|c| c * factor))
    }

    /// Directions in the environment's own frame that stand for all light that comes from it.
    pub fn sky_samples(&self) -> Vec<(Vec3, Vec3)> {
        let [lights, _] = &self.fitted;
        match self.omits_hidden {
            true => sky_samples::of_lights(lights, &self.points),
            false => sky_samples::of_map(&self.map),
        }
    }

    /// The places of lights that the map which is mirrored does not show.
    pub fn taken_out(&self) -> Range<usize> {
        self.of_fit - self.taken_out..self.of_fit
    }

    /// Lights and probes in the environment's own frame: what is decided by their sizes does not change as it turns.
    pub fn fitted(&self) -> [&[DistantLight]; 2] {
        self.fitted.each_ref().map(Vec::as_slice)
    }
}

/// Where each light's light comes from, where lights stand for parts of the map; else none.
fn points_of_cells(ambient: &AmbientLights, map: &Equirect) -> Arc<[LightPoints]> {
    match ambient.omits_hidden {
        true => light_points::of_cells(&ambient.lights, map).into(),
        false => Arc::default(),
    }
}

/// The map and its halves down to a height of 2 texels, flux conserved.
fn mip_levels(map: &Equirect) -> Vec<Equirect> {
    let mut levels = vec![map.clone()];
    while let Some(last) = levels.last().filter(|last| last.height() >= 4) {
        levels.push(last.resized(last.width() / 2, last.height() / 2));
    }
    levels
}

fn spherical_harmonics(map: &Equirect) -> [Vec4; 9] {
    Sh9::project(map).coefficients.map(|c| c.extend(0.0))
}

fn prefiltered(map: &Equirect) -> Vec<Equirect> {
    PrefilteredMap::new(map, PREFILTERED_WIDTH, PREFILTERED_LEVELS).levels().to_vec()
}

fn upload_maps(gpu: &Gpu, label: &str, levels: &[Equirect]) -> wgpu::TextureView {
    upload(gpu, label, levels.iter().map(Equirect::radiance))
}

/// Uploads a picture and its mip levels in full precision: a sun exceeds what 16 bits hold.
fn upload<'a>(gpu: &Gpu, label: &str, levels: impl IntoIterator<Item = &'a RgbImage>) -> wgpu::TextureView {
    let levels: Vec<&RgbImage> = levels.into_iter().collect();
    let size = levels.first().map_or([1, 1, 1], |level| [level.width(), level.height(), 1]);
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let count = (levels.len() as u32).max(1);
    let texture = gpu.texture(label, size, count, wgpu::TextureFormat::Rgba32Float, usage);
    for (i, level) in (0..).zip(levels) {
        let texels: Vec<[f32; 4]> = level.texels().iter().map(|texel| texel.extend(1.0).to_array()).collect();
        gpu.write_texture(&texture, [i, 0], [level.width(), level.height()], bytemuck::cast_slice(&texels));
    }
    texture.create_view(&Default::default())
}

/// Uploads a backdrop as large as the adapter's textures may be, with the radiance of a 1 in there.
fn upload_backdrop(gpu: &Gpu, mut backdrop: Arc<Backdrop>) -> (wgpu::TextureView, f32) {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    while backdrop.width().max(backdrop.height()) > limit {
        backdrop = Arc::new(backdrop.halved());
    }
    let [width, height] = [backdrop.width(), backdrop.height()];
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = gpu.texture("backdrop", [width, height, 1], 1, wgpu::TextureFormat::Rgb9e5Ufloat, usage);
    gpu.write_texture_in_parts(&texture, [width, height], bytemuck::cast_slice(backdrop.texels()));
    (texture.create_view(&Default::default()), backdrop.scale())
}

fn upload_emitters(gpu: &Gpu, emitters: &[layout::Emitter]) -> wgpu::Buffer {
    let mut uniform = layout::Emitters { count: emitters.len() as u32, ..Default::default() };
    for (slot, emitter) in uniform.emitters.iter_mut().zip(emitters) {
        *slot = *emitter;
    }
    gpu.buffer_with("emitters", &layout::bytes(&uniform), wgpu::BufferUsages::UNIFORM)
}
