//! The frame's lights as shaders see them, each with what may block it.

use std::f32::consts::PI;

use glam::Vec3;
use gnomon_lights::DistantLight;
use gnomon_picture::LUMINANCE;
use gnomon_scene::{AreaLightShape, PlacedLight};
use gnomon_shaders::layout;

use crate::TechniqueSettings;
use crate::batch_plan::{LightNeeds, is_sharp};
use crate::casters::{Casters, DrawnCasters};
use crate::geometry::Geometry;
use crate::light_frame::{footprint, hidden_deviation, light_uniform};
use crate::light_points::{self, LightPoints};
use crate::lighting::Lighting;
use crate::near_light_frame::near_light_uniform;
use crate::shading_points::samplings;
use crate::shadow::technique::ShadowTechnique;
use crate::view_slices::{ViewSlice, ViewSlices};

/// A light of the frame: the environment's, its probes, the scene's own.
#[derive(Clone, Copy)]
pub(crate) enum FrameLight<'a> {
    /// `slice` is the number of the part of the view that it shines on, where that is not all; `points` tell where its light comes from,
    /// where that is known.
    Distant {
        light: &'a DistantLight,
        role: u32,
        slice: Option<usize>,
        points: Option<&'a LightPoints>,
    },
    Near(&'a PlacedLight),
}

/// All lights in the order of the frame's list, those of the lighting as they are turned.
pub(crate) fn frame_lights<'a>(
    [lights, probes]: [&'a [DistantLight]; 2],
    lighting: &'a Lighting,
    near: &'a [PlacedLight],
) -> Vec<FrameLight<'a>> {
    let distant = |light, role, points| FrameLight::Distant { light, role, slice: None, points };
    let taken_out = lighting.taken_out();
    let role = |place| if taken_out.contains(&place) { layout::ROLE_TAKEN_OUT } else { layout::ROLE_LIGHT };
    let points = lighting.points.iter().map(Some).chain(std::iter::repeat(None));
    let lights = lights.iter().zip(points).enumerate();
    let lights = lights.map(|(place, (light, points))| distant(light, role(place), points));
    let probes = probes.iter().map(|probe| distant(probe, layout::ROLE_PROBE, None));
    lights.chain(probes).chain(near.iter().map(FrameLight::Near)).collect()
}

impl FrameLight<'_> {
    /// Flux of a light of the environment, in luminance.
    pub fn flux(&self) -> f32 {
        match self {
            Self::Distant { light, role: layout::ROLE_LIGHT | layout::ROLE_TAKEN_OUT, .. } => {
                light.radiance.dot(LUMINANCE) * light.solid_angle
            }
            _ => 0.0,
        }
    }

    /// Whether its shadows are sharp and its maps may therefore be larger.
    pub fn is_sharp(&self, total_flux: f32) -> bool {
        match self {
            Self::Distant { light, role: layout::ROLE_LIGHT | layout::ROLE_TAKEN_OUT, .. } => {
                is_sharp(footprint(light), self.flux() / total_flux.max(f32::MIN_POSITIVE))
            }
            _ => false,
        }
    }

    /// The same for a part of the view.
    pub fn for_slice(&self, slice: usize) -> Self {
        match *self {
            Self::Distant { light, role, points, .. } => {
                Self::Distant { light, role, slice: Some(slice), points }
            }
            Self::Near(_) => *self,
        }
    }

    /// What decides with which other lights it shares a batch. All lights of the environment have `total_flux`.
    pub fn needs(
        &self,
        technique: &dyn ShadowTechnique,
        settings: &TechniqueSettings,
        total_flux: f32,
    ) -> LightNeeds {
        let usual = settings.shadow_resolution;
        let most = if technique.has_sharp_maps() { settings.sharp_shadow_resolution } else { usual };
        let (resolution, is_sharp) = match self {
            Self::Distant { light, .. } => {
                let share = self.flux() / total_flux.max(f32::MIN_POSITIVE);
                let resolution = settings.shadow_sizing.resolution(footprint(light), share, [usual, most]);
                (resolution, self.is_sharp(total_flux))
            }
            Self::Near(light) => match distant(light) {
                Some(sun) => (settings.shadow_sizing.resolution(footprint(&sun), 1.0, [usual, most]), true),
                // The texels of a map show where nothing blurs them.
                None if light.shape.half_extent().max_element() <= SMALL_LAMP => {
                    (most.min(SMALL_LAMP_TEXELS * usual), true)
                }
                None => (usual, true),
            },
        };
        let resolution = if technique.depth_maps().is_some() { resolution } else { 1 };
        // Sharp lights are summed at the last list.
        LightNeeds { points: if is_sharp { samplings(settings).len() - 1 } else { 0 }, resolution }
    }
}

/// What one of the scene's own lights is where it is a sun.
pub(crate) fn distant(light: &PlacedLight) -> Option<DistantLight> {
    match light.shape {
        AreaLightShape::Sun { angular_radius } => {
            Some(DistantLight::around(-light.normal, light.tangent, angular_radius, light.radiance))
        }
        _ => None,
    }
}

/// A lamp so small [m], such as those of glTF files that give no extent, has maps so many times as wide as others.
const SMALL_LAMP: f32 = 0.05;
const SMALL_LAMP_TEXELS: u32 = 4;

/// Lights fitted around the scene as it stands.
#[derive(Default)]
pub(crate) struct FittedLights {
    pub uniforms: Vec<layout::Light>,
    pub casters: Vec<DrawnCasters>,
}

/// How lights are fitted.
pub(crate) struct LightFitting {
    /// Receivers are moved along their normal by so many texels.
    pub normal_offset_texels: f32,
    /// Simpler meshes may deviate by so many.
    pub caster_deviation_texels: f32,
    /// Whether grounds block lights that shine on their upper side.
    pub draws_grounds: bool,
    /// Rays to a light, where they are traced.
    pub rays: u32,
}

impl LightFitting {
    pub fn new(technique: &dyn ShadowTechnique, settings: &TechniqueSettings) -> Self {
        Self {
            normal_offset_texels: settings.normal_offset,
            caster_deviation_texels: settings.caster_deviation,
            draws_grounds: technique.draws_grounds(),
            rays: settings.shadow_settings.rays.samples,
        }
    }

    /// Fits `members` of the frame's list around the scene. The light `only` counts as a probe, which tells its visibility.
    pub fn fit(
        &self,
        all: &[FrameLight<'_>],
        members: &[usize],
        resolution: u32,
        (geometry, slices): (&Geometry, &ViewSlices),
        only: Option<usize>,
    ) -> FittedLights {
        let fitted = members.iter().filter_map(|&place| {
            let (mut uniform, casters) = self.fitted(all.get(place)?, resolution, geometry, slices);
            uniform.number = place as u32;
            if only == Some(place) {
                uniform.role = layout::ROLE_PROBE;
            }
            Some((uniform, casters))
        });
        let (uniforms, casters) = fitted.unzip();
        FittedLights { uniforms, casters }
    }

    fn fitted(
        &self,
        light: &FrameLight<'_>,
        resolution: u32,
        geometry: &Geometry,
        slices: &ViewSlices,
    ) -> (layout::Light, DrawnCasters) {
        let scene = &geometry.placed_boxes;
        let sun = match light {
            FrameLight::Near(light) => distant(light),
            FrameLight::Distant { .. } => None,
        };
        let light = match &sun {
            Some(light) => &FrameLight::Distant { light, role: layout::ROLE_SUN, slice: None, points: None },
            None => light,
        };
        let (mut uniform, wanted) = match *light {
            FrameLight::Distant { light, role, slice, points } => {
                let seen = slice.map_or(Some(ViewSlice::WHOLE), |slice| slices.get(slice));
                let Some(seen) = seen else {
                    let uniform = light_uniform(light, scene, &ViewSlice::WHOLE, resolution, 0.0);
                    let nowhere = layout::Light { role, to_distance: 0.0, ..uniform };
                    return (nowhere, DrawnCasters { draws: Vec::new(), deviation_world: 0.0 });
                };
                let mut uniform = light_uniform(light, scene, &seen, resolution, self.normal_offset_texels);
                if let Some(points) = points {
                    uniform.vector_irradiance =
                        light.solid_angle * light_points::mean_direction(light, points);
                }
                let deviation_world =
                    hidden_deviation(light, &uniform, resolution, self.caster_deviation_texels);
                let above = (!self.draws_grounds).then_some(light);
                (layout::Light { role, ..uniform }, Casters { above, deviation_world })
            }
            FrameLight::Near(light) => {
                let uniform = near_light_uniform(light, scene, resolution, self.normal_offset_texels);
                (uniform, Casters::default())
            }
        };
        let drawn = geometry.casters(&wanted);
        uniform.caster_deviation_world = drawn.deviation_world;
        (uniform, drawn)
    }
}

/// What the sums of these lights are multiplied by to lie within the range of halves, 6e-8 to 65504, with all of their precision down to a
/// thirty-millionth of the most that they can be: irradiance is no more than what all lights give a surface that faces them; a highlight, which
/// follows their radiance, may be brighter than the light.
pub(crate) fn sum_scales<'a>(lights: impl Iterator<Item = &'a layout::Light>) -> Vec3 {
    const MOST: Vec3 = Vec3::new(32768.0, 2048.0, 16384.0);
    let most = |light: &layout::Light| {
        let radiance = light.radiance.max_element();
        match (light.kind, light.role) {
            (layout::KIND_DISTANT, layout::ROLE_LIGHT) => {
                Vec3::new(radiance * light.solid_angle, radiance, 0.0)
            }
            (layout::KIND_DISTANT, layout::ROLE_TAKEN_OUT) => {
                Vec3::new(radiance * light.solid_angle, 0.0, PI * radiance)
            }
            (layout::KIND_DISTANT, layout::ROLE_PROBE) => Vec3::ZERO,
            _ => Vec3::new(0.0, 0.0, PI * radiance),
        }
    };
    let most: Vec3 = lights.map(most).sum();
    Vec3::select(most.cmpgt(Vec3::splat(1e-30)), MOST / most, Vec3::ONE)
}
