//! Debug views of a live renderer.

use gnomon_picture::tonemap::exposure_scale;
use gnomon_scene::{Bounds, Camera};
use gnomon_shaders::layout;

use super::{Lit, Renderer, Target};
use crate::debug_view::{self, DebugGroup, DebugPass, DebugView};
use crate::light_batches::LitScene;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// A view in force.
pub(super) struct Debug {
    view: &'static DebugView,
    light: usize,
    pass: DebugPass,
}

impl Debug {
    /// The light of the frame's list that alone is summed.
    pub fn only_light(&self, lit: &Lit) -> Option<usize> {
        self.view.sums_one_light().then(|| self.light_of(lit)).flatten()
    }

    /// What it needs of every batch of lights.
    pub fn groups(&self, gpu: &Gpu, view: &wgpu::Buffer, lit: &Lit) -> Vec<DebugGroup> {
        let background = &lit.lighting.seen;
        let group = |(lights, maps)| self.pass.group(gpu, view, background, lights, maps);
        lit.batches.lights_and_maps().map(group).collect()
    }

    /// The chosen light, or the last one where there are fewer.
    fn light_of(&self, lit: &Lit) -> Option<usize> {
        lit.batches.light_count().checked_sub(1).map(|last| self.light.min(last))
    }
}

impl Renderer {
    /// Shows one of [`crate::debug_view::DEBUG_VIEWS`] in place of the picture, from the next frame on; `"final"` is the picture. A view of
    /// one light shows the one numbered `light`, from 0 in the order of the light fit, followed by those of the ambient rest and of the
    /// scene ([`Renderer::light_count`] in all); a number past the last shows the last. [`crate::Frame::radiance`] then holds the
    /// view's values before sRGB encoding.
    ///
    /// # Errors
    /// [`RenderError::UnknownName`]; the view is then what it was.
    pub fn set_debug_view(&mut self, name: &str, light: usize) -> Result<(), RenderError> {
        let (gpu, passes) = (&self.gpu, &self.passes);
        let scopes = gpu.catch_errors();
        let debug = match debug_view::by_name(name)? {
            None => None,
            Some(view) => {
                let layouts = [&passes.gbuffer.read_layout, &passes.of_models.points.compose_layout];
                Some(Debug { view, light, pass: DebugPass::new(gpu, layouts)? })
            }
        };
        let shown = debug.as_ref().zip(self.state.lit.as_ref());
        let groups = shown.map(|(debug, lit)| debug.groups(gpu, &self.view, lit)).unwrap_or_default();
        scopes.finish()?;
        let scopes = gpu.catch_errors();
        if let Some(lit) = &mut self.state.lit {
            lit.batches.sum_only(gpu, debug.as_ref().and_then(|debug| debug.only_light(lit)));
            lit.debug_groups = groups;
        }
        self.debug = debug;
        scopes.finish()
    }

    /// Whether a debug view takes the place of the picture.
    pub fn shows_debug_view(&self) -> bool {
        self.debug.is_some()
    }

    /// Number of lights that a frame sums: of the environment, its ambient rest and the scene.
    pub fn light_count(&self) -> usize {
        self.state.lit.as_ref().map_or(0, |lit| lit.batches.light_count())
    }

    /// Draws the view into the samples of `target`.
    pub(super) fn encode_debug_view(
        &self,
        recorder: &mut Recorder<'_>,
        debug: &Debug,
        (lit, target, scene): (&Lit, &Target, LitScene<'_>),
        camera: &Camera,
        sample_size: [u32; 2],
    ) -> Result<(), RenderError> {
        let chosen = debug.light_of(lit).and_then(|light| lit.batches.place_of(light));
        if let Some((batch, _)) = chosen.filter(|_| debug.view.reads_map()) {
            lit.batches.prepare_again(recorder, scene, batch)?;
        }
        let [least, range] = depth_range(camera, self.geometry.bounds());
        let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
        let mut lights_before = 0;
        for (i, (group, light_count)) in lit.debug_groups.iter().zip(lit.batches.sizes()).enumerate() {
            let light = chosen.and_then(|(batch, light)| (batch == i).then_some(light));
            let parameters = layout::DebugParameters {
                light: light.unwrap_or(0),
                has_light: light.is_some().into(),
                has_maps: lit.technique.depth_maps().is_some().into(),
                to_viewer,
                lights_before,
                least_depth: least,
                depth_range: range,
                exposure: exposure_scale(self.settings().display.exposure.unwrap_or(0.0)),
                light_count,
                ..debug.view.parameters()
            };
            self.gpu.write(&group.parameters, &parameters);
            lights_before += light_count;
        }
        let shown = match debug.view.draws_all_lights() {
            true => 0..lit.debug_groups.len(),
            false => {
                let batch = chosen.map_or(0, |(batch, _)| batch);
                batch..batch + 1
            }
        };
        let Some([sums, _]) = target.points.compose_groups.first() else { return Ok(()) };
        let groups = [&target.gbuffer.group, sums];
        let batches = lit.debug_groups.iter().skip(shown.start).take(shown.len());
        debug.pass.encode(recorder, batches, groups, sample_size);
        Ok(())
    }
}

/// Least depth of what can be seen, and the range of depths, measured along the direction that the camera looks [m].
fn depth_range(camera: &Camera, bounds: Option<Bounds>) -> [f32; 2] {
    let Some(bounds) = bounds else { return [0.0, 1.0] };
    let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
    let (center, reach) =
        (-bounds.center().dot(to_viewer), (0.5 * (bounds.max - bounds.min)).dot(to_viewer.abs()));
    // What lies behind the camera is not seen.
    let least = (center - reach).max(-camera.eye().dot(to_viewer));
    [least, (center + reach - least).max(1e-6)]
}
