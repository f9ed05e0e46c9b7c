//! Drawing frames: whole, in bands, for a file, a benchmark or a window.

use bytemuck::pod_collect_to_vec;
use glam::Mat4;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::ToneMapping;
use gnomon_scene::Camera;
use gnomon_shaders::layout;

use super::bands::Band;
use super::{Frame, Lit, Renderer, State, Target};
use crate::RenderError;
use crate::camera::CameraMatrices;
use crate::compose::RADIANCE_FORMAT;
use crate::light_batches::LitScene;
use crate::recorder::{PassTiming, Recorder};
use crate::settings::{Chosen, in_range};
use crate::shading_points::SumPlanes;

impl Renderer {
    /// Draws one frame of `width` x `height` pixels and waits for it. Where the adapter allows no buffer for the light of all its
    /// samples it is drawn in bands of rows; [`Renderer::display_view`] then shows the last one.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for an empty or too large picture, [`RenderError::Device`] where the device failed,
    /// [`RenderError::NotFinite`] where it drew what is no picture.
    pub fn render(&mut self, camera: &Camera, width: u32, height: u32) -> Result<Frame, RenderError> {
        self.check_size([width, height])?;
        self.render_bands(camera, [width, height], &self.bands([width, height]))
    }

    pub(super) fn render_bands(
        &mut self,
        camera: &Camera,
        [width, height]: [u32; 2],
        bands: &[Band],
    ) -> Result<Frame, RenderError> {
        let (mut radiance, mut display, mut timings) = (Vec::new(), Vec::new(), Vec::new());
        for band in bands {
            add(&mut timings, self.submit_band(camera, [width, height], band)?);
            self.gpu.wait()?;
            let Some(target) = &self.target else {
                return Err(RenderError::Device("no frame was drawn".to_owned()));
            };
            let texels: Vec<[f32; 4]> =
                pod_collect_to_vec(&self.gpu.read_texture(&target.output.radiance, 16)?);
            let bytes: Vec<[u8; 4]> = pod_collect_to_vec(&self.gpu.read_texture(&target.output.display, 4)?);
            let before = ((band.kept.start - band.drawn.start) * width) as usize;
            let count = (band.kept.len() as u32 * width) as usize;
            let kept = texels.iter().skip(before).take(count);
            radiance.extend(kept.map(|&[r, g, b, _]| glam::Vec3::new(r, g, b)));
            display.extend(bytes.into_iter().skip(before).take(count));
        }
        let pixels = radiance.iter().filter(|radiance| !radiance.is_finite()).count();
        if pixels > 0 {
            return Err(RenderError::NotFinite { pixels, adapter: self.gpu.adapter().name.clone() });
        }
        let radiance = RgbImage::from_texels(width, height, radiance)
            .ok_or_else(|| RenderError::Device("the picture read back has another size".to_owned()))?;
        Ok(Frame { radiance, display, timings })
    }

    /// Draws one frame without reading it back, in bands as [`Renderer::render`] does, and waits until the device is idle: what a
    /// benchmark times.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn draw(&mut self, camera: &Camera, width: u32, height: u32) -> Result<Vec<PassTiming>, RenderError> {
        self.check_size([width, height])?;
        let mut timings = Vec::new();
        for band in self.bands([width, height]) {
            add(&mut timings, self.submit_band(camera, [width, height], &band)?);
            self.gpu.wait()?;
        }
        Ok(timings)
    }

    /// Draws one frame without waiting for it: for a window, which shows [`Renderer::display_view`].
    ///
    /// # Errors
    /// As [`Renderer::render`], and [`RenderError::OverLimit`] for a picture that would have to be drawn in bands; faults of the device
    /// may come only with a later call.
    pub fn submit(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<Vec<PassTiming>, RenderError> {
        self.check_size([width, height])?;
        self.submit_band(camera, [width, height], &Band::whole(height))
    }

    /// Waits until everything that was submitted is drawn.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the device failed.
    pub fn wait(&self) -> Result<(), RenderError> {
        self.gpu.wait()
    }

    fn check_size(&self, [width, height]: [u32; 2]) -> Result<(), RenderError> {
        let largest =
            self.gpu.device.limits().max_texture_dimension_2d / self.settings().techniques.supersample;
        in_range("picture width", width, 1..=largest)?;
        in_range("picture height", height, 1..=largest)?;
        Ok(())
    }

    /// Draws the rows of a band of a picture of `width` x `height` pixels, top row first, without waiting for them.
    fn submit_band(
        &mut self,
        camera: &Camera,
        [width, height]: [u32; 2],
        band: &Band,
    ) -> Result<Vec<PassTiming>, RenderError> {
        let rows = band.drawn.clone();
        let is_first = band.kept.start == 0;
        self.gpu.check()?;
        let size = [width, rows.len() as u32];
        let planes = self.sum_planes();
        let fits = |target: &Target| target.size == size && target.points.iter().all(|p| p.planes == planes);
        if !self.target.as_ref().is_some_and(fits) {
            self.target = Some(self.new_target(size)?);
        }
        self.fit_lights()?;
        let State { chosen, compose, cache, lit } = &self.state;
        let (Some(lit), Some(target), settings) = (lit, &self.target, &chosen.settings) else {
            return Err(RenderError::Device("no lighting was set".to_owned()));
        };
        let samples = settings.techniques.supersample;
        let sample_size = size.map(|side| side * samples);
        let matrices = CameraMatrices::new(camera, width as f32 / height as f32, self.bounds);
        let matrices = matrices.cropped(height, rows);
        self.write_uniforms((lit, target), camera, &matrices, sample_size);

        let mut recorder = Recorder::new(&self.gpu, settings.measure.profile);
        if is_first {
            self.passes.transform.encode(&mut recorder, &self.geometry);
        }
        recorder.end_pass("transform")?;
        self.passes.gbuffer.encode(
            &mut recorder,
            &target.gbuffer,
            &self.view_group,
            &self.geometry,
            &self.materials,
        );
        recorder.end_pass("gbuffer")?;
        let gbuffer_group = &target.gbuffer.group;
        for points in &target.points {
            self.passes.points.encode(&mut recorder, points, &self.view_group, gbuffer_group);
        }
        recorder.end_pass("points")?;
        let scene = LitScene {
            geometry: &self.geometry,
            materials: &self.materials,
            gbuffer: gbuffer_group,
            points: &target.points,
            is_first_band: is_first,
        };
        lit.batches.encode(&mut recorder, &lit.light, scene)?;
        let (mut exposure, mut tone_mapping) =
            (settings.display.exposure.unwrap_or(0.0), settings.display.tone_mapping);
        if let Some(debug) = &self.debug {
            self.encode_debug_view(&mut recorder, debug, (lit, target, scene), camera, sample_size)?;
            recorder.end_pass("debug view")?;
            (exposure, tone_mapping) = (0.0, ToneMapping::Linear);
        } else {
            if is_first {
                self.passes.cache.encode(&mut recorder, cache, &lit.environment.cache);
            }
            recorder.end_pass("radiance cache")?;
            let groups = [
                (layout::GROUP_FRAME, &lit.environment.compose),
                (layout::GROUP_SURFACE, gbuffer_group),
                (layout::GROUP_PASS, &target.points[0].compose_group),
            ];
            compose.encode(&mut recorder, groups, sample_size);
            recorder.end_pass("compose")?;
        }
        self.passes.resolve.encode(&mut recorder, &target.output, samples, exposure, tone_mapping);
        recorder.end_pass("resolve")?;
        recorder.finish()
    }

    fn write_uniforms(
        &self,
        (lit, target): (&Lit, &Target),
        camera: &Camera,
        matrices: &CameraMatrices,
        [width, height]: [u32; 2],
    ) {
        let (interleave, planes) = (target.gbuffer.interleave, target.points[0].planes);
        let Chosen { settings, unshadowed, .. } = &self.state.chosen;
        let environment_from_world = Mat4::from_quat(self.world_from_environment.inverse());
        let flag = |on, flag| if on { flag } else { 0 };
        let view = layout::View {
            clip_from_world: matrices.clip_from_world,
            world_from_clip: matrices.world_from_clip,
            eye_world: matrices.eye_world,
            size: [width, height].into(),
            flags: flag(settings.display.background, layout::FLAG_BACKGROUND)
                | flag(unshadowed.spherical_harmonics, layout::FLAG_SPHERICAL_HARMONICS)
                | flag(planes.specular, layout::FLAG_SPECULAR_SUMS)
                | flag(planes.near, layout::FLAG_NEAR_SUMS),
            shadow_sampling: settings.techniques.shadow_sampling,
            sample_extent: matrices.view_width / width as f32,
            interleave,
            sum_scales: lit.batches.sum_scales(),
            residual_sh: lit.lighting.residual_sh,
            full_sh: lit.lighting.full_sh,
            environment_from_world,
        };
        self.gpu.write(&self.view, &view);
        let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
        self.state.cache.write(&self.gpu, to_viewer, environment_from_world);
    }

    /// The sums of light that scene and lights ask for.
    fn sum_planes(&self) -> SumPlanes {
        SumPlanes { specular: self.is_glossy, near: !self.near_lights.is_empty() }
    }

    /// Plans batches anew where the target's points ask for it, and fits lights around the scene where anything moved.
    fn fit_lights(&mut self) -> Result<(), RenderError> {
        let room = self.room_for_points();
        if self.state.lit.as_ref().is_some_and(|lit| !lit.batches.is_planned_for(&room))
            && let Some(lit) = self.relit(&self.near_lights)?
        {
            self.take_lit(lit);
        }
        if let Some(lit) = &mut self.state.lit {
            let only = self.debug.as_ref().and_then(|debug| debug.only_light(lit));
            let lights = (&lit.lighting, self.near_lights.as_slice());
            lit.batches.fit(&self.gpu, lights, &self.geometry, only);
        }
        Ok(())
    }

    fn new_target(&self, size: [u32; 2]) -> Result<Target, RenderError> {
        let gpu = &self.gpu;
        let techniques = &self.settings().techniques;
        let sample_size = size.map(|side| side * techniques.supersample);
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let [width, height] = sample_size;
        let samples = gpu
            .texture("samples", [width, height, 1], 1, RADIANCE_FORMAT, usage)
            .create_view(&Default::default());
        Ok(Target {
            size,
            gbuffer: self.passes.gbuffer.target(gpu, &self.materials, sample_size, techniques.supersample),
            points: [self.passes.points.points(
                gpu,
                sample_size,
                techniques.shadow_sampling,
                self.sum_planes(),
                &samples,
            )?],
            output: self.passes.resolve.output(gpu, &samples, size),
        })
    }
}

/// Adds a band's times to those of the bands before it.
fn add(timings: &mut Vec<PassTiming>, of_band: Vec<PassTiming>) {
    if timings.is_empty() {
        *timings = of_band;
        return;
    }
    for (sum, pass) in timings.iter_mut().zip(of_band) {
        sum.milliseconds += pass.milliseconds;
    }
}
