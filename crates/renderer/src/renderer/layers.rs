//! Layers of a picture, drawn after it and of what it left.

use glam::Mat4;
use gnomon_scene::Camera;
use gnomon_shaders::layout;

use super::bands::Band;
use super::{Frame, Renderer, State};
use crate::RenderError;
use crate::gpu::TextureReadBack;
use crate::layers::{Layer, LayerSource, RenderedLayers};
use crate::recorder::{Clock, Recorder, new_encoder};
use crate::seen::{SeenPass, seen_frame};

/// The frame before.
pub(super) struct Before {
    camera: Camera,
    /// Of the vertices, in world space.
    positions: wgpu::Buffer,
}

impl Renderer {
    /// Draws one frame as [`Renderer::render`] does, and layers of it.
    ///
    /// # Errors
    /// As [`Renderer::render_layers_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn render_layers(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        layers: &[Layer],
    ) -> Result<(Frame, RenderedLayers), RenderError> {
        let frame = self.render_layers_async(camera, width, height, layers);
        self.gpu.wait_for(frame)
    }

    /// Draws one frame as [`Renderer::render_async`] does, and layers of it. Those that are named twice are drawn once.
    ///
    /// # Errors
    /// As [`Renderer::render_async`], and [`RenderError::NoLayers`] while a debug view takes the picture's place.
    pub fn render_layers_async(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        layers: &[Layer],
    ) -> impl Future<Output = Result<(Frame, RenderedLayers), RenderError>> + Send + use<> {
        let begun = self.begin_frame_with(camera, [width, height], layers);
        async move { begun?.frame().await }
    }

    fn begin_frame_with(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        layers: &[Layer],
    ) -> Result<super::bands::BandsInFlight, RenderError> {
        self.check_size(size)?;
        if self.debug.is_some() {
            return Err(RenderError::NoLayers { reason: "a debug view takes the place of the picture" });
        }
        let mut wanted: Vec<Layer> = Vec::new();
        for layer in layers {
            if !wanted.contains(layer) {
                wanted.push(*layer);
            }
        }
        self.begin_bands(camera, size, &self.bands(size), &wanted)
    }

    /// Takes the scene as it stands, seen by `camera`, for the frame before those that are drawn from now on: [`Layer::Motion`] is the way
    /// since then. Another scene forgets it; without it nothing moves.
    ///
    /// # Errors
    /// [`RenderError::Device`] where the device failed.
    pub fn remember_for_motion(&mut self, camera: &Camera) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        self.upload_changes();
        let mut encoder = new_encoder(&self.gpu);
        let mut recorder = Recorder::new(&self.gpu, &mut encoder, Clock::Off);
        self.passes.transform.encode(&mut recorder, &self.geometry);
        let [positions, ..] = self.geometry.vertex_buffers();
        let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
        let copy = self.gpu.empty_buffer("positions before", positions.size(), usage);
        recorder.encoder.copy_buffer_to_buffer(positions, 0, &copy, 0, positions.size());
        self.gpu.queue.submit([encoder.finish()]);
        scopes.finish()?;
        self.before = Some(Before { camera: camera.clone(), positions: copy });
        Ok(())
    }

    /// Submits layers of a band that has just been drawn, each with its read-back.
    pub(super) fn begin_layers(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
        layers: &[Layer],
    ) -> Result<Vec<TextureReadBack>, RenderError> {
        if layers.is_empty() {
            return Ok(Vec::new());
        }
        if self.seen.is_none() {
            self.seen = Some(SeenPass::new(&self.gpu, &self.passes.gbuffer)?);
        }
        let rows = [size[0], band.drawn.len() as u32];
        if let (Some(seen), Some(target)) = (&self.seen, &mut self.target) {
            target.seen.get_or_insert_with(|| seen.target(&self.gpu, rows));
        }
        let seen_group = self.draw_seen(camera, size, band)?;
        layers.iter().map(|layer| self.begin_layer(layer.source(), &seen_group, rows)).collect()
    }

    /// Draws what is seen, and gives the bind group of its frame.
    fn draw_seen(
        &self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
    ) -> Result<wgpu::BindGroup, RenderError> {
        let (Some(lit), Some(target), Some(pass)) = (&self.state.lit, &self.target, &self.seen) else {
            return Err(RenderError::Device("no frame was drawn".to_owned()));
        };
        let Some(seen) = &target.seen else {
            return Err(RenderError::Device("no frame was drawn".to_owned()));
        };
        let matrices = self.matrices(camera, size, band.drawn.clone());
        let pixels = [size[0], band.drawn.len() as u32];
        let of_picture = self.view_of((lit, target), &matrices, pixels);
        let view = layout::View { supersample: 1, interleave: 1, ..of_picture };
        let before = self.before.as_ref();
        let clip_before: Mat4 = match before {
            Some(before) => self.matrices(&before.camera, size, band.drawn.clone()).clip_from_world,
            None => matrices.clip_from_world,
        };
        let frame = seen_frame(camera, size, &band.drawn, clip_before);
        let mut encoder = new_encoder(&self.gpu);
        let mut recorder = Recorder::new(&self.gpu, &mut encoder, Clock::Off);
        let geometry = (&self.geometry, before.map(|before| &before.positions));
        let group = pass.draw(&mut recorder, seen, (&view, &frame), geometry, &self.materials);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(group)
    }

    fn begin_layer(
        &self,
        source: LayerSource,
        seen_group: &wgpu::BindGroup,
        size: [u32; 2],
    ) -> Result<TextureReadBack, RenderError> {
        let gpu = &self.gpu;
        let State { compose, lit, .. } = &self.state;
        let (Some(lit), Some(target), Some(pass)) = (lit, &self.target, &self.seen) else {
            return Err(RenderError::Device("no frame was drawn".to_owned()));
        };
        let mut encoder = new_encoder(gpu);
        let mut recorder = Recorder::new(gpu, &mut encoder, Clock::Off);
        let texture = match (source, &target.seen) {
            (LayerSource::Seen(layer), Some(seen)) => {
                pass.write(&mut recorder, seen, seen_group, layer);
                &seen.words
            }
            (LayerSource::Seen(_), None) => return Err(RenderError::Device("no frame was drawn".to_owned())),
            (LayerSource::Composed(part), _) => {
                target.points.compose_part(gpu, part);
                let groups = [&lit.environment.compose, &target.gbuffer.group];
                compose.encode(&mut recorder, groups, size, &target.points);
                &target.values
            }
        };
        let read = TextureReadBack::new(gpu, &mut encoder, texture, 16);
        gpu.queue.submit([encoder.finish()]);
        target.points.compose_part(gpu, layout::PART_PICTURE);
        Ok(read)
    }
}
