//! Drawing frames: whole, in bands, for a file, a benchmark or a window.

use std::ops::Range;
use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};
use gnomon_picture::tonemap::ToneMapping;
use gnomon_scene::Camera;
use gnomon_shaders::layout;

use super::bands::{Band, BandInFlight, BandsInFlight};
use super::layers::LayerTask;
use super::{Frame, Lit, Renderer, State, Target};
use crate::RenderError;
use crate::camera::CameraMatrices;
use crate::compose::Composed;
use crate::gbuffer::GBuffer;
use crate::gpu::TextureReadBack;
use crate::recorder::{Clock, FrameTimings, Recorder, new_encoder};
use crate::settings::{Background, Chosen, in_range};
use crate::shading_points::{PointPlan, SumPlanes};
use crate::view_slices::ViewSlices;

impl Renderer {
    /// Draws one frame of `width` x `height` pixels and waits for it: [`Renderer::render_async`], waited for.
    ///
    /// # Errors
    /// As [`Renderer::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render(&mut self, camera: &Camera, width: u32, height: u32) -> Result<Frame, RenderError> {
        let frame = self.render_async(camera, width, height);
        self.gpu.wait_for(frame)
    }

    /// Draws one frame of `width` x `height` pixels and reads it back. When this returns everything is recorded and submitted, and the
    /// renderer is free for the next frame; the future is ready once the GPU has drawn it and the device was polled after that
    /// ([`wgpu::Device::poll`], [`wgpu::Queue::submit`]; browsers do so by themselves).
    ///
    /// Where the adapter allows no buffer for the light of all its samples the picture is drawn in bands of rows;
    /// [`Renderer::display_view`] then shows the last one.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for an empty or too large picture, [`RenderError::Device`] where the device failed,
    /// [`RenderError::NotFinite`] where it drew what is no picture.
    pub fn render_async(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> impl Future<Output = Result<Frame, RenderError>> + Send + use<> {
        let size = [width, height];
        let begun =
            self.check_size(size).and_then(|()| self.begin_bands(camera, size, &self.bands(size), &[]));
        async move { Ok(begun?.frame().await?.0) }
    }

    /// Submits every band with its read-back, and that of its layers: each is copied before the next one is drawn in its place.
    pub(super) fn begin_bands(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        bands: &[Band],
        layers: &[LayerTask],
    ) -> Result<BandsInFlight, RenderError> {
        let gpu = self.gpu.clone();
        let labels = Arc::clone(&self.labels);
        let of_layers = layers.iter().map(|layer| layer.empty(&labels)).collect();
        let mut in_flight =
            BandsInFlight { gpu: gpu.clone(), size, bands: Vec::new(), layers: of_layers, labels };
        for band in bands {
            let scopes = gpu.catch_errors();
            self.judge_clocks(camera, size, band)?;
            let mut encoder = new_encoder(&gpu);
            let timings = self.record_band(&mut encoder, camera, size, band, self.clock())?;
            let Some(target) = &self.target else {
                return Err(RenderError::Device("no frame was drawn".to_owned()));
            };
            let mut read = |texture, bytes| TextureReadBack::new(&gpu, &mut encoder, texture, bytes);
            let (radiance, display) = (read(&target.output.radiance, 16), read(&target.output.display, 4));
            gpu.queue.submit([encoder.finish()]);
            let layers = self.begin_layers(camera, size, band, layers)?;
            in_flight.bands.push(BandInFlight { band: band.clone(), radiance, display, layers, timings });
            scopes.finish()?;
        }
        Ok(in_flight)
    }

    /// Draws one frame without reading it back, in bands as [`Renderer::render`] does, and waits until the device is idle: what a
    /// benchmark times.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn draw(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<Vec<crate::PassTiming>, RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let mut times = Vec::new();
        for band in self.bands(size) {
            let timings = self.submit_band(camera, size, &band, self.settings().measure.profile)?;
            self.gpu.wait()?;
            crate::recorder::add_times(&mut times, self.gpu.wait_for(timings.passes())?);
        }
        Ok(times)
    }

    /// Draws one frame without waiting for it: for a window, which shows [`Renderer::display_view`]. Gives the frame's number, under
    /// which [`Renderer::take_times`] tells its times later where they are asked for ([`crate::MeasureSettings::profile`]).
    ///
    /// # Errors
    /// As [`Renderer::render`], and [`RenderError::OverLimit`] for a picture that would have to be drawn in bands; faults of the device
    /// may come only with a later call.
    pub fn submit(&mut self, camera: &Camera, width: u32, height: u32) -> Result<u64, RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let is_timed = self.settings().measure.profile && self.in_flight.has_room();
        let timings = self.submit_band(camera, size, &Band::whole(height), is_timed)?;
        Ok(self.in_flight.add(is_timed.then_some(timings)))
    }

    /// Records one frame into an encoder of the embedding program, which submits it: for a program that draws everything in one
    /// submission. What changes from frame to frame is uploaded through the device's queue at once, so that an encoder can hold one
    /// frame of a renderer, and it is to be submitted before the renderer draws another. Passes are not timed.
    ///
    /// # Errors
    /// As [`Renderer::submit`].
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<(), RenderError> {
        let size = [width, height];
        self.check_size(size)?;
        let scopes = self.gpu.catch_errors();
        self.record_band(encoder, camera, size, &Band::whole(height), Clock::Off)?;
        scopes.finish()
    }

    fn submit_band(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
        is_timed: bool,
    ) -> Result<FrameTimings, RenderError> {
        let scopes = self.gpu.catch_errors();
        self.judge_clocks(camera, size, band)?;
        let clock = if is_timed { self.clock() } else { Clock::Off };
        let mut encoder = new_encoder(&self.gpu);
        let timings = self.record_band(&mut encoder, camera, size, band, clock)?;
        self.gpu.queue.submit([encoder.finish()]);
        scopes.finish()?;
        Ok(timings)
    }

    /// Waits until everything that was submitted is drawn.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(&self) -> Result<(), RenderError> {
        self.gpu.wait()
    }

    pub(super) fn check_size(&self, [width, height]: [u32; 2]) -> Result<(), RenderError> {
        let largest =
            self.gpu.device.limits().max_texture_dimension_2d / self.settings().techniques.supersample;
        in_range("picture width", width, 1..=largest)?;
        in_range("picture height", height, 1..=largest)?;
        Ok(())
    }

    /// Records the rows of a band of a picture of `width` x `height` pixels, top row first.
    pub(super) fn record_band(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        [width, height]: [u32; 2],
        band: &Band,
        clock: Clock,
    ) -> Result<FrameTimings, RenderError> {
        let rows = band.drawn.clone();
        let is_first = band.kept.start == 0;
        self.gpu.check()?;
        let size = [width, rows.len() as u32];
        let plan = self.point_plan(size);
        let shown = (self.composed_side(), self.layer_count(), self.relief.is_some());
        let fits = |target: &Target| {
            let GBuffer { layers, relief, .. } = &target.gbuffer;
            target.points.plan == plan && (target.composed.side, layers.count, relief.is_some()) == shown
        };
        if !self.target.as_ref().is_some_and(fits) {
            self.target = Some(self.new_target(size, plan)?);
        }
        self.upload_changes();
        let slices = self.view_slices(camera, [width, height]);
        self.fit_lights(slices)?;
        let State { chosen, compose, cache, lit } = &self.state;
        let (Some(lit), Some(target), settings) = (lit, &self.target, &chosen.settings) else {
            return Err(RenderError::Device("no lighting was set".to_owned()));
        };
        let samples = settings.techniques.supersample;
        let sample_size = size.map(|side| side * samples);
        let matrices = self.matrices(camera, [width, height], rows);
        self.write_uniforms((lit, target), camera, &matrices, sample_size);

        let mut recorder = Recorder::new(&self.gpu, encoder, clock);
        if is_first {
            self.passes.transform.encode(&mut recorder, &self.geometry);
            if let Some(scene) = &mut self.ray_scene {
                scene.encode(&self.gpu, &mut recorder, &self.passes.refit, &self.geometry);
            }
        }
        recorder.end_pass("transform")?;
        self.passes.gbuffer.encode(
            &mut recorder,
            &target.gbuffer,
            self.drawn_scene(),
            |recorder, layer| {
                self.light_surfaces(recorder, lit, self.lit_scene(target, (is_first, layer == 0)))?;
                if self.debug.is_some() {
                    return Ok(());
                }
                if is_first && layer == 0 {
                    self.passes.of_models.cache.encode(
                        recorder,
                        cache,
                        &lit.environment.cache,
                        &self.materials.tables,
                    );
                }
                recorder.end_pass("radiance cache")?;
                let groups = [&lit.environment.compose, &target.gbuffer.group];
                compose.encode(recorder, groups, size, (&target.points, &target.composed), layer);
                recorder.end_pass("compose")
            },
        )?;
        let (mut exposure, mut tone_mapping) =
            (settings.display.exposure.unwrap_or(0.0), settings.display.tone_mapping);
        if let Some(debug) = &self.debug {
            let scene = self.lit_scene(target, (is_first, true));
            self.encode_debug_view(&mut recorder, debug, (lit, target, scene), camera, sample_size)?;
            recorder.end_pass("debug view")?;
            (exposure, tone_mapping) = (0.0, ToneMapping::Linear);
        }
        let side = target.composed.side;
        self.passes.resolve.encode(&mut recorder, &target.output, side, exposure, tone_mapping);
        recorder.end_pass("resolve")?;
        Ok(recorder.finish())
    }

    /// Of some rows of a picture of `width` x `height` pixels.
    pub(super) fn matrices(
        &self,
        camera: &Camera,
        [width, height]: [u32; 2],
        rows: Range<u32>,
    ) -> CameraMatrices {
        let matrices = CameraMatrices::new(camera, width as f32 / height as f32, self.geometry.bounds());
        matrices.cropped(height, rows)
    }

    fn write_uniforms(
        &self,
        (lit, target): (&Lit, &Target),
        camera: &Camera,
        matrices: &CameraMatrices,
        size: [u32; 2],
    ) {
        self.gpu.write(&self.view, &self.view_of((lit, target), matrices, size));
        let environment_from_world = Mat4::from_quat(self.world_from_environment.inverse());
        let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
        self.state.cache.write(&self.gpu, to_viewer, environment_from_world);
    }

    /// The view of a picture of so many samples.
    pub(super) fn view_of(
        &self,
        (lit, target): (&Lit, &Target),
        matrices: &CameraMatrices,
        [width, height]: [u32; 2],
    ) -> layout::View {
        let (interleave, plan) = (target.gbuffer.interleave, &target.points.plan);
        let Chosen { settings, unshadowed, .. } = &self.state.chosen;
        let [residual_sh, full_sh] = lit.lighting.spherical_harmonics();
        let environment_from_world = Mat4::from_quat(self.world_from_environment.inverse());
        let flag = |on, flag| if on { flag } else { 0 };
        layout::View {
            clip_from_world: matrices.clip_from_world,
            world_from_clip: matrices.world_from_clip,
            eye_world: matrices.eye_world,
            size: [width, height].into(),
            flags: flag(settings.display.background == Background::Environment, layout::FLAG_BACKGROUND)
                | flag(unshadowed.spherical_harmonics, layout::FLAG_SPHERICAL_HARMONICS)
                | flag(plan.planes.specular, layout::FLAG_SPECULAR_SUMS)
                | flag(plan.planes.near, layout::FLAG_NEAR_SUMS)
                | flag(plan.planes.wide, layout::FLAG_WIDE_SUMS)
                | flag(plan.planes.evened, layout::FLAG_EVENED_SUMS)
                | flag(lit.lighting.omits_hidden || lit.lighting.stands_alone, layout::FLAG_OWN_LIGHT)
                | flag(lit.technique.is_grainy(), layout::FLAG_GRAINY_SUMS)
                | flag(lit.gloss.is_some(), layout::FLAG_TRACED_GLOSS)
                | flag(mirrors_scene(lit), layout::FLAG_MIRRORED_SCENE)
                | flag(unshadowed.samples_lobes, layout::FLAG_SAMPLED_GLOSS)
                | flag(settings.techniques.bumps.scatter(), layout::FLAG_BUMP_SCATTER),
            supersample: plan.supersample,
            sample_extent: matrices.view_width / width as f32,
            interleave,
            point_lists: plan.lists(),
            point_list_count: plan.samplings.len() as u32,
            gloss_samples: settings.techniques.gloss_samples,
            bumps: settings.techniques.bumps.shade().into(),
            rough_gloss_list: lit.batches.first_list() as u32,
            sum_scales: lit.sum_scales(),
            background_factor: lit.lighting.background_factor(),
            environment_factor: lit.lighting.factor(),
            residual_sh,
            full_sh,
            environment_from_world,
            ground_center: self.ground.map_or(Vec3::ZERO, |ground| ground.center),
            ground_camera_height: self.ground.map_or(0.0, |ground| ground.camera_height),
            ground_fade: self.ground.map_or(Vec2::new(0.0, 1.0), |ground| Vec2::new(ground.from, ground.to)),
        }
    }

    /// The sums of light that scene and lights ask for.
    pub(super) fn sum_planes(&self) -> SumPlanes {
        SumPlanes {
            specular: self.surfaces.iter().any(|surface| !surface.is_matte()),
            near: !self.near_lights.is_empty() || self.state.lit.as_ref().is_some_and(mirrors_scene),
            wide: self.has_wide_sums,
            evened: self.state.lit.as_ref().is_some_and(|lit| {
                let [_, probes] = lit.lighting.fitted();
                // Groups of lights are summed one after another: averages of each by itself would not add up.
                !self.has_wide_sums
                    && lit.technique.is_grainy()
                    && lit.lighting.omits_hidden
                    && probes.is_empty()
            }),
        }
    }

    /// Plans batches anew where the target's points ask for it, and fits lights around the scene where anything moved.
    fn fit_lights(&mut self, slices: ViewSlices) -> Result<(), RenderError> {
        let room = self.room_for_points();
        self.slice_count = slices.count();
        if self.state.lit.as_ref().is_some_and(|lit| !lit.batches.is_planned_for(room, slices.count()))
            && let Some(lit) = self.relit()?
        {
            self.state.lit = Some(lit);
        }
        if let Some(lit) = &mut self.state.lit {
            let only = self.debug.as_ref().and_then(|debug| debug.only_light(lit));
            let lights = (&lit.lighting, self.near_lights.as_slice());
            lit.batches.fit(&self.gpu, lights, (&self.geometry, slices), (only, &self.light_groups));
        }
        Ok(())
    }

    /// Slices of a picture's view; a debug view shows lights as one.
    fn view_slices(&self, camera: &Camera, size: [u32; 2]) -> ViewSlices {
        let resolution = self.settings().techniques.sharp_shadow_resolution;
        match self.debug {
            None => ViewSlices::new(camera, size, resolution, &self.geometry.placed_boxes),
            Some(_) => ViewSlices::default(),
        }
    }

    /// The lists of points for a picture of `size` pixels.
    pub(super) fn point_plan(&self, size: [u32; 2]) -> PointPlan {
        PointPlan::new(&self.settings().techniques, size, self.sum_planes())
    }

    /// Values along a pixel's side of what is composed.
    fn composed_side(&self) -> u32 {
        if self.debug.is_some() { self.settings().techniques.supersample } else { 1 }
    }

    /// Layers of surfaces that light passes in part; a debug view has none.
    fn layer_count(&self) -> u32 {
        match self.debug {
            None => self.settings().techniques.blended_layers.min(self.geometry.most_layers()),
            Some(_) => 0,
        }
    }

    fn new_target(&self, size: [u32; 2], plan: PointPlan) -> Result<Target, RenderError> {
        let (gpu, passes) = (&self.gpu, &self.passes);
        let layers = self.layer_count();
        let composed = Composed::new(gpu, size, self.composed_side(), layers > 0);
        let samples = (plan.sample_size, plan.supersample);
        let gbuffer = passes.gbuffer.target(gpu, &self.materials, samples, (layers, self.relief.is_some()));
        let opacities = &gbuffer.layers.opacity_array;
        Ok(Target {
            points: passes.of_models.points.points(gpu, plan, &composed, (layers, opacities))?,
            output: passes.resolve.output(gpu, &composed.values, size),
            gbuffer,
            composed,
            seen: None,
        })
    }
}

fn mirrors_scene(lit: &Lit) -> bool {
    lit.gloss.as_ref().is_some_and(|gloss| gloss.mirrors_scene)
}
