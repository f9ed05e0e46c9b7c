//! Layers of a picture, drawn after it and of what it left.

use glam::Mat4;
use gnomon_lights::DistantLight;
use gnomon_picture::LUMINANCE;
use gnomon_scene::Camera;
use gnomon_shaders::layout;

use super::bands::{Band, BandsInFlight};
use super::{Frame, Lit, Renderer, State, Target};
use crate::RenderError;
use crate::cryptomatte::{Labels, sample_cameras};
use crate::gpu::TextureReadBack;
use crate::layers::{Layer, LayerRequest, LayerSource, RenderedLayer, RenderedLayers};
use crate::lighting::Lighting;
use crate::recorder::{Clock, Recorder, new_encoder};
use crate::seen::{DrawnVertices, SeenPass, SeenTarget, seen_frame};
use crate::settings::in_range;

/// Most layers that lights become.
const MOST_LIGHT_LAYERS: usize = 1024;

/// A layer to be drawn.
pub(super) struct LayerTask {
    pub layer: Layer,
    /// Of one of several.
    pub name: Option<String>,
    pub source: LayerSource,
}

impl LayerTask {
    /// The layer without any pixel.
    pub fn empty(&self, labels: &Labels) -> RenderedLayer {
        RenderedLayer::empty(self.layer, self.name.as_deref(), labels)
    }
}

/// The frame before.
pub(super) struct Before {
    camera: Camera,
    vertices: DrawnVertices,
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
        layers: impl Into<LayerRequest>,
    ) -> Result<(Frame, RenderedLayers), RenderError> {
        let frame = self.render_layers_async(camera, width, height, layers);
        self.gpu.wait_for(frame)
    }

    /// Draws one frame as [`Renderer::render_async`] does, and layers of it. With [`Layer::Lights`] light is summed in floats, so that layers add
    /// up to the picture, and once more for each of them.
    ///
    /// # Errors
    /// As [`Renderer::render_async`], and [`RenderError::NoLayers`] while a debug view takes the picture's place and where lights do not add up.
    pub fn render_layers_async<R: Into<LayerRequest>>(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        layers: R,
    ) -> impl Future<Output = Result<(Frame, RenderedLayers), RenderError>> + Send + use<R> {
        let begun = self.begin_with_layers(camera, [width, height], &layers.into());
        (self.light_groups, self.has_wide_sums) = (Vec::new(), false);
        async move { begun?.frame().await }
    }

    fn begin_with_layers(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        request: &LayerRequest,
    ) -> Result<BandsInFlight, RenderError> {
        self.check_size(size)?;
        if self.debug.is_some() && !request.layers.is_empty() {
            return Err(RenderError::NoLayers { reason: "a debug view takes the place of the picture" });
        }
        in_range("most layers of lights", request.light_layers, 1..=MOST_LIGHT_LAYERS)?;
        let mut tasks: Vec<LayerTask> = Vec::new();
        for &layer in &request.layers {
            match layer.source() {
                _ if tasks.iter().any(|task| task.layer == layer) => {}
                Some(source) => tasks.push(LayerTask { layer, name: None, source }),
                None => tasks.extend(self.light_tasks(request.light_layers)?),
            }
        }
        self.begin_bands(camera, size, &self.bands(size), &tasks)
    }

    /// What the picture is the sum of, and groups of lights for it.
    fn light_tasks(&mut self, most: usize) -> Result<Vec<LayerTask>, RenderError> {
        let State { chosen, lit, .. } = &self.state;
        let Some(lit) = lit else { return Err(no_frame()) };
        if !chosen.compositing.is_sum {
            return Err(RenderError::NoLayers {
                reason: "by the subtractive rule the picture is not the sum of its lights",
            });
        }
        let Lighting { lights, probes, of_fit, .. } = &lit.lighting;
        let flux = |light: &DistantLight| light.solid_angle * light.radiance.dot(LUMINANCE);
        let mut places: Vec<usize> = (0..*of_fit).collect();
        places.sort_by(|&a, &b| flux(&lights[b]).total_cmp(&flux(&lights[a])));
        let first_near = lights.len() + probes.len();
        let near = first_near..first_near + self.near_lights.len();
        let places: Vec<usize> = near.clone().chain(places).collect();
        let alone = if places.len() > most { most - 1 } else { places.len() };
        // What is ambient has number 0.
        let mut groups = vec![0; near.end];
        for (i, &place) in places.iter().enumerate() {
            groups[place] = i.min(alone) as u32 + 1;
        }
        (self.light_groups, self.has_wide_sums) = (groups, true);
        let task = |name: String, source| LayerTask { layer: Layer::Lights, name: Some(name), source };
        let of_group = |group: u32| LayerSource::Group { group, part: layout::PART_LIGHTS };
        let named = places.iter().take(alone).map(|place| format!("light-{place:03}"));
        let rest = (places.len() > alone).then(|| "lights-rest".to_owned());
        let lights = (1..).zip(named.chain(rest)).map(|(group, name)| task(name, of_group(group)));
        let ambient = LayerSource::Group { group: 0, part: layout::PART_DIFFUSE };
        let others = [
            ("emission", LayerSource::Composed(layout::PART_EMISSION)),
            ("reflections", LayerSource::Composed(layout::PART_SPECULAR)),
            ("background", LayerSource::Composed(layout::PART_BACKGROUND)),
            ("ambient", ambient),
        ];
        Ok(others.map(|(name, source)| task(name.to_owned(), source)).into_iter().chain(lights).collect())
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
        let mut copy = |label, source: &wgpu::Buffer, usage| {
            let copy = self.gpu.empty_buffer(label, source.size(), usage | wgpu::BufferUsages::COPY_DST);
            recorder.encoder.copy_buffer_to_buffer(source, 0, &copy, 0, source.size());
            copy
        };
        let positions = copy("positions before", positions, wgpu::BufferUsages::VERTEX);
        let placements = copy("placements before", self.geometry.placements(), wgpu::BufferUsages::STORAGE);
        self.gpu.queue.submit([encoder.finish()]);
        scopes.finish()?;
        let vertices = DrawnVertices { positions, placements };
        self.before = Some(Before { camera: camera.clone(), vertices });
        Ok(())
    }

    /// Submits layers of a band that has just been drawn, each with its read-back, of a matte one for each sample.
    pub(super) fn begin_layers(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        band: &Band,
        layers: &[LayerTask],
    ) -> Result<Vec<Vec<TextureReadBack>>, RenderError> {
        if layers.is_empty() {
            return Ok(Vec::new());
        }
        if self.seen.is_none() {
            self.seen = Some(SeenPass::new(&self.gpu, &self.passes.gbuffer)?);
        }
        let pixels = [size[0], band.drawn.len() as u32];
        if let (Some(pass), Some(target)) = (&self.seen, &mut self.target) {
            target.seen.get_or_insert_with(|| pass.target(&self.gpu, pixels));
        }
        let State { lit, .. } = &self.state;
        let (Some(lit), Some(target), Some(pass)) = (lit, &self.target, &self.seen) else {
            return Err(no_frame());
        };
        let drawn = Drawn { lit, target, pass, seen: target.seen.as_ref().ok_or_else(no_frame)? };
        let group = self.draw_seen(&drawn, camera, size, band);
        // Samples of mattes take the place of what is seen through the middle, and light of groups that of all light.
        let mut order: Vec<usize> = (0..layers.len()).collect();
        order.sort_by_key(|&i| match layers[i].source {
            LayerSource::Seen(_) | LayerSource::Composed(_) => 0,
            LayerSource::Matte(_) => 1,
            LayerSource::Group { .. } => 2,
        });
        let mut reads: Vec<Vec<TextureReadBack>> = layers.iter().map(|_| Vec::new()).collect();
        for i in order {
            if let LayerSource::Matte(layer) = layers[i].source {
                for camera in sample_cameras(camera, size[0]) {
                    let group = self.draw_seen(&drawn, &camera, size, band);
                    reads[i].push(self.begin_layer(&drawn, LayerSource::Seen(layer), &group, pixels)?);
                }
            } else {
                reads[i].push(self.begin_layer(&drawn, layers[i].source, &group, pixels)?);
            }
        }
        target.points.compose_part(&self.gpu, layout::PART_PICTURE);
        lit.batches.show_group(&self.gpu, None);
        Ok(reads)
    }

    /// Draws what is seen, and gives the bind group of its frame.
    fn draw_seen(&self, drawn: &Drawn<'_>, camera: &Camera, size: [u32; 2], band: &Band) -> wgpu::BindGroup {
        let matrices = self.matrices(camera, size, band.drawn.clone());
        let pixels = [size[0], band.drawn.len() as u32];
        let of_picture = self.view_of((drawn.lit, drawn.target), &matrices, pixels);
        let view = layout::View { supersample: 1, interleave: 1, ..of_picture };
        let before = self.before.as_ref();
        let clip_before: Mat4 = match before {
            Some(before) => self.matrices(&before.camera, size, band.drawn.clone()).clip_from_world,
            None => matrices.clip_from_world,
        };
        let frame = seen_frame(camera, size, &band.drawn, clip_before);
        let mut encoder = new_encoder(&self.gpu);
        let mut recorder = Recorder::new(&self.gpu, &mut encoder, Clock::Off);
        let geometry = (&self.geometry, before.map(|before| &before.vertices));
        let group = drawn.pass.draw(&mut recorder, drawn.seen, (&view, &frame), geometry, &self.materials);
        self.gpu.queue.submit([encoder.finish()]);
        group
    }

    fn begin_layer(
        &self,
        &Drawn { lit, target, pass, seen }: &Drawn<'_>,
        source: LayerSource,
        seen_group: &wgpu::BindGroup,
        size: [u32; 2],
    ) -> Result<TextureReadBack, RenderError> {
        let gpu = &self.gpu;
        let mut encoder = new_encoder(gpu);
        let mut recorder = Recorder::new(gpu, &mut encoder, Clock::Off);
        let texture = match source {
            LayerSource::Seen(layer) | LayerSource::Matte(layer) => {
                pass.write(&mut recorder, seen, seen_group, layer);
                &seen.words
            }
            LayerSource::Composed(part) | LayerSource::Group { part, .. } => {
                target.points.compose_part(gpu, part);
                self.compose_again(&mut recorder, (lit, target), source, size)?;
                &target.composed.texture
            }
        };
        let read = TextureReadBack::new(gpu, &mut encoder, texture, 16);
        gpu.queue.submit([encoder.finish()]);
        Ok(read)
    }

    /// Composes what the picture has left of its light. That is only what lies behind surfaces that light passes in part: with those, every
    /// one of their layers is lit again.
    fn compose_again(
        &self,
        recorder: &mut Recorder<'_>,
        (lit, target): (&Lit, &Target),
        source: LayerSource,
        size: [u32; 2],
    ) -> Result<(), RenderError> {
        if target.gbuffer.layers.count == 0 {
            return self.compose_source(recorder, (lit, target), (source, 0), size);
        }
        self.passes.gbuffer.encode(recorder, &target.gbuffer, self.drawn_scene(), |recorder, layer| {
            lit.batches.show_group(&self.gpu, None);
            self.light_surfaces(recorder, lit, self.lit_scene(target, (false, false)))?;
            recorder.submit();
            self.compose_source(recorder, (lit, target), (source, layer), size)?;
            recorder.submit();
            Ok(())
        })
    }

    /// Composes the G-buffer as it stands, one of the layers of surfaces that light passes in part or what lies behind them.
    fn compose_source(
        &self,
        recorder: &mut Recorder<'_>,
        (lit, target): (&Lit, &Target),
        (source, layer): (LayerSource, u32),
        size: [u32; 2],
    ) -> Result<(), RenderError> {
        if let LayerSource::Group { group, .. } = source {
            lit.batches.show_group(&self.gpu, Some(group));
            let scene = self.lit_scene(target, (false, false));
            for stage in &target.points.stages {
                let groups = [&self.view_group, &target.gbuffer.group];
                self.passes.of_models.points.inherit(recorder, &target.points, stage, groups);
                lit.batches.encode_group(recorder, &lit.light, scene, (stage, group))?;
            }
        }
        let groups = [&lit.environment.compose, &target.gbuffer.group];
        self.state.compose.encode(recorder, groups, size, (&target.points, &target.composed), layer);
        Ok(())
    }
}

/// A band that has just been drawn.
struct Drawn<'a> {
    lit: &'a Lit,
    target: &'a Target,
    pass: &'a SeenPass,
    seen: &'a SeenTarget,
}

fn no_frame() -> RenderError {
    RenderError::Device("no lighting was set".to_owned())
}
