//! Everything that changes while running goes one way: it is made anew, checked, and then takes the place of what there was.

use std::sync::Arc;

use glam::Quat;
use gnomon_brdf::Surface;
use gnomon_envmap::Grade;
use gnomon_lights::LightSet;
use gnomon_scene::{PlacedFade, PlacedLight, Scene};

use super::state::{EnvironmentGroups, Lit, Surroundings};
use super::{ModelPasses, Renderer, Target};
use crate::bumps::{MaterialHeights, NO_BUMPS, Preparation, Relief};
use crate::compose::ComposePass;
use crate::cryptomatte::Labels;
use crate::geometry::{Geometry, MovedGeometry};
use crate::gloss::Reflections;
use crate::lighting::{Lighting, PreparedLighting};
use crate::materials::{MaterialRecords, Materials};
use crate::radiance_cache::RadianceCache;
use crate::ray_scene::{self, RayScene};
use crate::settings::{Chosen, in_range};
use crate::{Gpu, RenderError, RenderSettings, shadow};

/// What a renderer is to take over, all of it or nothing ([`Renderer::change`]). What is `None` stays as it is.
#[derive(Default)]
pub struct Change<'a> {
    /// Settings. Those of the ambient rest ([`RenderSettings::lighting`]) count with [`LightingChange::Fit`], and before there is any
    /// lighting; otherwise they stay what the lighting was made with.
    pub settings: Option<RenderSettings>,
    /// The scene.
    pub scene: Option<SceneChange<'a>>,
    /// How the environment is turned: what was seen towards `d` is then seen towards `world_from_environment * d`.
    pub world_from_environment: Option<Quat>,
    /// What the environment's radiance is multiplied by.
    pub grade: Option<Grade>,
    /// Environment or lights.
    pub lighting: Option<LightingChange<'a>>,
}

/// A scene, and what of it is another than before. Whatever this says, a scene that places other meshes is taken over whole.
#[derive(Clone, Copy)]
pub enum SceneChange<'a> {
    /// Everything may be. Only meshes and textures that the renderer does not hold yet are uploaded.
    Whole(&'a Scene),
    /// Materials, reflectance models among them.
    Materials(&'a Scene),
    /// The pose: node transforms, joints, morph weights.
    Pose(&'a Scene),
}

/// Other lights.
pub enum LightingChange<'a> {
    /// An environment. What it was worked out with for the ambient rest becomes part of the settings.
    Prepared(Box<PreparedLighting>),
    /// Another fit to the environment in force, or another treatment of its ambient rest.
    Fit(&'a LightSet),
}

/// What a change makes anew. Nothing of it is in force yet, and nothing in force knows of it.
struct Next {
    /// With the models that shaders know.
    gpu: Gpu,
    /// Where they are more than before.
    passes: Option<ModelPasses>,
    chosen: Chosen,
    compose: Option<ComposePass>,
    cache: Option<RadianceCache>,
    lit: Option<Lit>,
    /// For lights that stay.
    groups: Option<EnvironmentGroups>,
    rays: NextRays,
    relief: NextRelief,
    world_from_environment: Quat,
    grade: Grade,
    scene: NextScene,
}

/// What it makes of a scene.
#[derive(Default)]
struct NextScene {
    geometry: Option<NextGeometry>,
    materials: Option<NextMaterials>,
    near_lights: Option<Vec<PlacedLight>>,
    /// Whether it has a ground that fades, and where.
    ground: Option<Option<PlacedFade>>,
    surfaces: Option<Vec<Surface>>,
    heights: Option<Vec<MaterialHeights>>,
    labels: Option<Labels>,
}

enum NextGeometry {
    New(Box<Geometry>),
    Moved(Box<MovedGeometry>),
}

/// What rays are traced through from then on.
enum NextRays {
    None,
    Same,
    New(Box<RayScene>),
}

/// What is prepared of heights from then on.
enum NextRelief {
    None,
    Same,
    New(Box<Relief>),
}

enum NextMaterials {
    New {
        materials: Box<Materials>,
        /// Of the target.
        gbuffer: Option<wgpu::BindGroup>,
    },
    Changed(MaterialRecords),
}

impl Renderer {
    /// Takes a change over by the least work: a pose, a turn, other parameters of materials and how radiance is shown make nothing new on
    /// the device; other techniques leave meshes, textures and maps of the environment where they are; a scene uploads what of its
    /// meshes and textures is not there yet.
    ///
    /// Where it fails, everything is as it was. That counts for what the device reports, too, as when it has no memory left. Only a browser
    /// reports that later: then the change is in force, and the next call tells the error.
    ///
    /// # Errors
    /// [`RenderError::Option`] and [`RenderError::OutOfRange`] for what cannot be, [`RenderError::OverLimit`] and
    /// [`RenderError::OverBudget`] for what adapter or memory cannot hold, [`RenderError::Device`] for what the device reports.
    pub fn change(&mut self, change: Change<'_>) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let next = self.prepare(change);
        scopes.finish()?;
        self.take(next?);
        Ok(())
    }

    fn prepare(&self, change: Change<'_>) -> Result<Next, RenderError> {
        let is = &self.state;
        let Change { settings, scene, world_from_environment, grade, lighting } = change;
        let scene = scene.map_or(Ok(NextScene::default()), |scene| self.next_scene(scene))?;
        let surfaces = scene.surfaces.as_ref().unwrap_or(&self.surfaces);
        let models = self.gpu.models.with(surfaces);
        let other_models = models != self.gpu.models;
        let gpu = &self.gpu.with_models(models);
        let mut chosen = settings.map_or(Ok(is.chosen.clone()), |settings| Chosen::new(gpu, settings))?;
        if is.lit.is_some() && !matches!(lighting, Some(LightingChange::Fit(_))) {
            chosen.take_rest(is.chosen.ambient, is.chosen.settings.lighting.ambient_cells);
        }
        let world_from_environment =
            world_from_environment.map_or(Ok(self.world_from_environment), checked_rotation)?;
        let grade = grade.map_or(Ok(self.grade), checked_grade)?;
        let lighting = match lighting {
            None => None,
            Some(LightingChange::Prepared(prepared)) => {
                chosen.take_rest(prepared.ambient, prepared.ambient_cells);
                Some(Lighting::new(gpu, *prepared)?)
            }
            Some(LightingChange::Fit(set)) => {
                let Some(lit) = &is.lit else {
                    return Err(RenderError::Device("no lighting was set".to_owned()));
                };
                let ambient = chosen.ambient.lights(set, chosen.settings.lighting.ambient_cells)?;
                Some(lit.lighting.clone().with_lights(gpu, ambient))
            }
        };
        let passes = match other_models {
            true => Some(ModelPasses::new(gpu, &self.passes.gbuffer)?),
            false => None,
        };
        let other_techniques = chosen.settings.techniques != is.chosen.settings.techniques;
        let compose = match other_techniques || other_models {
            true => Some(self.passes.compose(gpu, &chosen)?),
            false => None,
        };
        let lobes = chosen.cached_lobes(surfaces);
        let cache = match other_techniques || !is.cache.has_room_for(&lobes) {
            true => Some(self.new_cache(&chosen, lobes)),
            false => None,
        };
        let near_lights = scene.near_lights.as_ref().unwrap_or(&self.near_lights);
        let (geometry, is_new) = match &scene.geometry {
            Some(NextGeometry::New(geometry)) => (geometry.as_ref(), true),
            _ => (&self.geometry, false),
        };
        let in_force = is.lit.as_ref().map(|lit| &lit.lighting);
        let placed_boxes = match &scene.geometry {
            Some(NextGeometry::Moved(moved)) => moved.placed_boxes(),
            _ => &geometry.placed_boxes,
        };
        let lamps_are_wide = shadow::lamps_are_wide(near_lights, placed_boxes.around);
        let technique =
            lighting.as_ref().or(in_force).map(|l| self.technique(&chosen, l, geometry, lamps_are_wide));
        let casts = technique.is_some_and(|technique| technique.casts_shadows());
        let suits = casts && ray_scene::has_room_for(gpu, geometry);
        // Lights that stand for themselves are what is reflected.
        let has_map = lighting.as_ref().or(in_force).is_some_and(|lighting| !lighting.stands_alone);
        let traces_gloss = has_map && chosen.settings.techniques.gloss.traces(surfaces, suits);
        let traces_rays = traces_gloss || technique.is_some_and(|technique| technique.traces_rays());
        let needs_edges = technique.is_some_and(|technique| technique.needs_edges());
        let mirrors_scene = traces_gloss && chosen.settings.paths.reflections == Reflections::Scene;
        let (materials, are_new) = match &scene.materials {
            Some(NextMaterials::New { materials, .. }) => (materials.as_ref(), true),
            _ => (&self.materials, false),
        };
        let serves = |scene: &RayScene| {
            let hits_serve = scene.hits.is_some() == mirrors_scene && !(mirrors_scene && are_new);
            !is_new && hits_serve && (scene.edges.is_some() || !needs_edges)
        };
        let ray_scene = match traces_rays && !self.ray_scene.as_ref().is_some_and(serves) {
            true => {
                let materials = mirrors_scene.then_some(materials);
                let before = self.ray_scene.as_ref();
                Some(RayScene::new(gpu, &self.passes.refit, geometry, materials, before, needs_edges)?)
            }
            false => None,
        };
        let heights = scene.heights.as_ref().unwrap_or(&self.heights);
        let preparation = chosen.preparation(heights);
        let relief = match (preparation, &self.relief) {
            (None, _) => NextRelief::None,
            (Some(wanted), Some(is)) if wanted == is.preparation && scene.heights.is_none() => {
                NextRelief::Same
            }
            (Some(wanted), is) => {
                NextRelief::New(Box::new(Relief::new(gpu, &self.passes.relief, heights, wanted, is.as_ref())))
            }
        };
        let bumps = preparation.map_or(NO_BUMPS, Preparation::module);
        // More or fewer lights of the scene need other maps; what is bound of a scene for rays is another with it.
        let needs_maps = other_techniques
            || other_models
            || near_lights.len() != self.near_lights.len()
            || ray_scene.is_some()
            || is.lit.as_ref().is_some_and(|lit| lit.gloss.is_some() != traces_gloss)
            || is.lit.as_ref().is_some_and(|lit| lit.bumps != bumps)
            || technique.map(|t| t.name()) != is.lit.as_ref().map(|lit| lit.technique.name());
        let surroundings = technique.map(|technique| Surroundings {
            gpu,
            chosen: &chosen,
            technique,
            compose: compose.as_ref().unwrap_or(&is.compose),
            cache: cache.as_ref().unwrap_or(&is.cache),
            near_lights,
            ray_scene: ray_scene.as_ref().or(self.ray_scene.as_ref()).filter(|_| traces_rays),
            traces_gloss,
            world_from_environment,
            grade,
            bumps,
        });
        let lighting = lighting.or_else(|| in_force.filter(|_| needs_maps).cloned());
        let lit = surroundings
            .as_ref()
            .zip(lighting)
            .map(|(surroundings, lighting)| self.lit(surroundings, lighting))
            .transpose()?;
        let stays = is.lit.as_ref().filter(|_| lit.is_none() && cache.is_some());
        let groups = surroundings
            .as_ref()
            .zip(stays)
            .map(|(surroundings, lit)| self.environment_groups(surroundings, &lit.lighting));
        let rays = match (traces_rays, ray_scene) {
            (false, _) => NextRays::None,
            (true, None) => NextRays::Same,
            (true, Some(scene)) => NextRays::New(Box::new(scene)),
        };
        let gpu = gpu.clone();
        Ok(Next {
            gpu,
            passes,
            compose,
            cache,
            lit,
            groups,
            rays,
            relief,
            world_from_environment,
            grade,
            scene,
            chosen,
        })
    }

    fn next_scene(&self, change: SceneChange<'_>) -> Result<NextScene, RenderError> {
        let (SceneChange::Whole(scene) | SceneChange::Materials(scene) | SceneChange::Pose(scene)) = change;
        let placed = self.geometry.placed_by(scene);
        let moves = placed.is_none() || !matches!(change, SceneChange::Materials(_));
        let looks_different = placed.is_none() || !matches!(change, SceneChange::Pose(_));
        let (gpu, passes) = (&self.gpu, &self.passes);
        let mut next = NextScene { ground: Some(scene.placed_fade()), ..NextScene::default() };
        if moves {
            next.near_lights = Some(scene.placed_lights());
            next.geometry = Some(match placed {
                Some(placed) => NextGeometry::Moved(Box::new(self.geometry.moved(scene, &placed)?)),
                None => {
                    let geometry = Geometry::new(gpu, &passes.transform, scene, Some(&self.geometry))?;
                    NextGeometry::New(Box::new(geometry))
                }
            });
        }
        if looks_different {
            next.labels = Some(Labels::of(scene));
            next.heights = Some(MaterialHeights::of(scene));
            next.surfaces = Some(scene.materials.iter().map(|material| material.surface).collect());
            next.materials = Some(match self.materials.records_of(gpu, scene) {
                Some(records) => NextMaterials::Changed(records),
                None => {
                    let materials =
                        Materials::new(gpu, &passes.gbuffer.material_layout, scene, Some(&self.materials))?;
                    let group = |target: &Target| passes.gbuffer.group_with(gpu, &target.gbuffer, &materials);
                    NextMaterials::New {
                        gbuffer: self.target.as_ref().map(group),
                        materials: Box::new(materials),
                    }
                }
            });
        }
        Ok(next)
    }

    /// Nothing here can fail: it makes nothing on the device. What lies in buffers that stay is written with the next frame.
    fn take(&mut self, next: Next) {
        let Next {
            gpu,
            passes,
            chosen,
            compose,
            cache,
            lit,
            groups,
            rays,
            relief,
            world_from_environment,
            grade,
            scene,
        } = next;
        self.gpu = gpu;
        if let Some(passes) = passes {
            self.passes.of_models = passes;
            // Made again for what asks for them.
            self.seen = None;
        }
        let NextScene { geometry, materials, near_lights, ground, surfaces, heights, labels } = scene;
        self.labels = labels.map_or_else(|| Arc::clone(&self.labels), Arc::new);
        let mut refit = geometry.is_some();
        match geometry {
            Some(NextGeometry::New(geometry)) => {
                self.geometry = *geometry;
                self.before = None;
            }
            Some(NextGeometry::Moved(moved)) => self.geometry.take(*moved),
            None => {}
        }
        match rays {
            NextRays::None => self.ray_scene = None,
            NextRays::New(scene) => {
                self.warnings.extend(scene.edges.iter().flat_map(|edges| edges.faults.iter().cloned()));
                self.ray_scene = Some(*scene);
            }
            NextRays::Same => {
                if let Some(scene) = self.ray_scene.as_mut().filter(|_| refit) {
                    scene.moved();
                }
            }
        }
        match materials {
            Some(NextMaterials::New { materials, gbuffer }) => {
                self.materials = *materials;
                if let (Some(target), Some(group)) = (&mut self.target, gbuffer) {
                    target.gbuffer.group = group;
                }
            }
            Some(NextMaterials::Changed(records)) => self.materials.change(records),
            None => {}
        }
        if let Some(near_lights) = near_lights {
            self.near_lights = near_lights;
        }
        self.ground = ground.unwrap_or(self.ground);
        if let Some(surfaces) = surfaces {
            self.surfaces = surfaces;
        }
        if let Some(heights) = heights {
            self.heights = heights;
        }
        match relief {
            NextRelief::None => self.relief = None,
            NextRelief::New(relief) => self.relief = Some(*relief),
            NextRelief::Same => {}
        }
        let is = &mut self.state;
        is.chosen = chosen;
        if let Some(compose) = compose {
            is.compose = compose;
        }
        match cache {
            Some(cache) => is.cache = cache,
            None => is.cache.rewrite(is.chosen.cached_lobes(&self.surfaces)),
        }
        if let (Some(lit), Some(groups)) = (&mut is.lit, groups) {
            lit.environment = groups;
        }
        match (&mut is.lit, lit) {
            (lit, Some(new)) => *lit = Some(new),
            (Some(lit), None) => {
                if (world_from_environment, grade) != (self.world_from_environment, self.grade) {
                    lit.lighting.set(world_from_environment, grade);
                    refit = true;
                }
                if refit {
                    lit.batches.refit();
                }
            }
            (None, None) => {}
        }
        (self.world_from_environment, self.grade) = (world_from_environment, grade);
    }

    /// Brings to the GPU what was changed in buffers that stayed.
    pub(super) fn upload_changes(&mut self) {
        self.geometry.upload(&self.gpu);
        let hits = self.ray_scene.as_ref().and_then(|scene| scene.hits.as_ref());
        self.materials.upload(&self.gpu, hits.map(|hits| &hits.materials));
    }
}

fn checked_rotation(rotation: Quat) -> Result<Quat, RenderError> {
    in_range("length of the environment's rotation", rotation.length(), 0.999..=1.001)?;
    Ok(rotation.normalize())
}

fn checked_grade(grade: Grade) -> Result<Grade, RenderError> {
    for factor in [grade.light, grade.background].map(|factor| factor.to_array()).concat() {
        in_range("factor of the environment's radiance", factor, 0.0..=1e12)?;
    }
    Ok(grade)
}
