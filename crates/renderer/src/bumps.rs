//! Relief of materials with heights: what it hides and scatters is prepared when a scene or the settings change and drawn over the G-buffer.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec4};
use gnomon_bumps::{Prepared, Shape};
use gnomon_options::choices;
use gnomon_scene::{HeightMap, Scene};
use gnomon_shaders::layout;

use crate::bindings::{Binding, D2};
use crate::gbuffer::{self, DrawnScene, GBuffer};
use crate::materials::address;
use crate::mip_chain::{half_bytes, mip_chain};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

choices! {
    /// What the heights of materials do. A normal map alone only shades.
    pub enum Bumps {
        /// They shade, shadow and light each other.
        Scatter = "scatter",
        /// They shade and cast shadows on each other.
        Shadow = "shadow",
        /// They bend normals.
        Shade = "shade",
        /// Nothing.
        Off = "off",
    }
}

choices! {
    /// How it is kept from which directions bumps are lit.
    pub enum BumpShadows {
        /// An ellipse for every texel (Heidrich 2001).
        Ellipses = "ellipses",
        /// Horizons in eight azimuths (Max 1988).
        Horizons = "horizons",
    }
}

impl Bumps {
    /// Whether anything has to be prepared.
    fn is_prepared(self) -> bool {
        matches!(self, Self::Scatter | Self::Shadow)
    }

    /// Whether they light each other.
    pub(crate) fn scatter(self) -> bool {
        self == Self::Scatter
    }

    /// Whether they bend normals.
    pub(crate) fn shade(self) -> bool {
        self != Self::Off
    }
}

impl BumpShadows {
    /// The shape, its number in shaders, and the module that knows it.
    fn shape(self) -> (Shape, u32, &'static str) {
        match self {
            Self::Ellipses => (Shape::Ellipses, layout::RELIEF_ELLIPSES, "bumps_ellipses"),
            Self::Horizons => (Shape::Horizons, layout::RELIEF_HORIZONS, "bumps_horizons"),
        }
    }
}

/// Module for slot `bumps` without relief.
pub(crate) const NO_BUMPS: &str = "bumps_none";

/// What is to be prepared, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Preparation {
    shadows: BumpShadows,
    scatters: bool,
}

impl Preparation {
    /// `None` where nothing is prepared of these heights.
    pub fn new(bumps: Bumps, shadows: BumpShadows, heights: &[MaterialHeights]) -> Option<Self> {
        let needed = bumps.is_prepared() && !heights.is_empty();
        needed.then_some(Self { shadows, scatters: bumps.scatter() })
    }

    /// Module for slot `bumps`.
    pub fn module(self) -> &'static str {
        self.shadows.shape().2
    }
}

/// A material's heights as they lie on its meshes.
#[derive(Clone)]
pub(crate) struct MaterialHeights {
    /// Number of the material.
    material: usize,
    map: Arc<HeightMap>,
    scale: f32,
    /// [m].
    extent: Vec2,
}

impl MaterialHeights {
    /// Those of a scene that some mesh shows.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let heights = |(material, entry): (usize, &gnomon_scene::Material)| {
            let height = entry.height?;
            let extent = scene.height_extent(material)?;
            let map = Arc::clone(&scene.height_maps[height.map.0]);
            Some(Self { material, map, scale: height.scale, extent })
        };
        scene.materials.iter().enumerate().filter_map(heights).collect()
    }

    fn is_same_field(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.map, &other.map) && self.scale == other.scale && self.extent == other.extent
    }
}

/// Everything that is prepared of a scene's heights.
pub(crate) struct Relief {
    pub preparation: Preparation,
    fields: Vec<(MaterialHeights, wgpu::BindGroup)>,
    /// Place in `fields` of every material that has one.
    of_material: HashMap<usize, usize>,
}

impl Relief {
    /// Prepares heights; those that `before` has in the same way are not worked out again.
    pub fn new(
        gpu: &Gpu,
        pass: &ReliefPass,
        heights: &[MaterialHeights],
        preparation: Preparation,
        before: Option<&Self>,
    ) -> Self {
        let before = before.filter(|before| before.preparation == preparation);
        let mut fields: Vec<(MaterialHeights, wgpu::BindGroup)> = Vec::new();
        let mut of_material = HashMap::new();
        for heights in heights {
            let place =
                fields.iter().position(|(field, _)| field.is_same_field(heights)).unwrap_or_else(|| {
                    let known = before.into_iter().flat_map(|before| &before.fields);
                    let known = known
                        .filter(|(field, _)| field.is_same_field(heights))
                        .map(|(_, group)| group.clone())
                        .next();
                    let group = known.unwrap_or_else(|| pass.prepared(gpu, heights, preparation));
                    fields.push((heights.clone(), group));
                    fields.len() - 1
                });
            of_material.insert(heights.material, place);
        }
        Self { preparation, fields, of_material }
    }

    fn group(&self, material: usize) -> Option<&wgpu::BindGroup> {
        self.of_material.get(&material).map(|&place| &self.fields[place].1)
    }
}

/// Draws what is prepared over the G-buffer.
pub(crate) struct ReliefPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl ReliefPass {
    /// `view` and `materials` are the layouts of the groups that the G-buffer is drawn with.
    pub fn new(gpu: &Gpu, [view, materials]: [&wgpu::BindGroupLayout; 2]) -> Result<Self, RenderError> {
        let sampled = Binding::Texture { dimension: D2, filterable: true };
        let bindings =
            [(0, Binding::Uniform), (1, sampled), (2, sampled), (3, sampled), (4, Binding::Sampler)];
        let layout = gpu.layout("relief", wgpu::ShaderStages::FRAGMENT, &bindings);
        let shader = gpu.shader("relief", &[])?;
        let groups =
            [(layout::GROUP_FRAME, view), (layout::GROUP_SURFACE, materials), (layout::GROUP_PASS, &layout)];
        let pipeline = gbuffer::pipeline(
            gpu,
            &shader,
            "relief_fragment",
            &groups,
            (&[gbuffer::FORMAT; 2], wgpu::CompareFunction::Equal),
        );
        Ok(Self { layout, pipeline })
    }

    /// Works a field out and uploads it.
    fn prepared(&self, gpu: &Gpu, heights: &MaterialHeights, preparation: Preparation) -> wgpu::BindGroup {
        let MaterialHeights { map, scale, extent, .. } = heights;
        let (shape, code, _) = preparation.shadows.shape();
        let prepared = Prepared::new(map, *scale, *extent, shape, preparation.scatters);
        let upload = |label, texels: Vec<Vec4>, size: [u32; 2]| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
            let level_count = size[0].max(size[1]).ilog2() + 1;
            let [width, height] = size;
            let texture =
                gpu.texture(label, [width, height, 1], level_count, wgpu::TextureFormat::Rgba16Float, usage);
            let levels = mip_chain(texels, size.map(|side| side as usize));
            for (level, texels) in (0..).zip(half_bytes(&levels)) {
                let size = size.map(|side| (side >> level).max(1));
                gpu.write_texture(&texture, [level, 0], size, &texels);
            }
            texture.create_view(&Default::default())
        };
        let lit =
            |first: usize| prepared.lit.iter().map(|lit| Vec4::from_slice(&lit[first..first + 4])).collect();
        let [first, second] = [0, 4].map(|first| upload("relief", lit(first), prepared.size));
        let scattered = if prepared.scattered.is_empty() {
            upload("scattering", vec![Vec4::ZERO], [1, 1])
        } else {
            let texels = prepared.scattered.iter().map(|s| Vec4::new(s.even, s.slope.x, s.slope.y, s.gain));
            upload("scattering", texels.collect(), prepared.scattered_size)
        };
        let uniform = layout::ReliefMap { extent: *extent, shape: code };
        let uniform = gpu.shared_buffer("relief", &uniform, wgpu::BufferUsages::UNIFORM);
        let [u, v] = map.wrap().map(address);
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("relief"),
            address_mode_u: u,
            address_mode_v: v,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: 8,
            ..Default::default()
        });
        let texture = wgpu::BindingResource::TextureView;
        gpu.bind_group(
            "relief",
            &self.layout,
            &[
                (0, uniform.as_entire_binding()),
                (1, texture(&first)),
                (2, texture(&second)),
                (3, texture(&scattered)),
                (4, wgpu::BindingResource::Sampler(&sampler)),
            ],
        )
    }

    /// Draws meshes with heights into the target's relief, where they are what the camera sees.
    pub fn encode(
        &self,
        recorder: &mut Recorder<'_>,
        target: &GBuffer,
        scene: DrawnScene<'_>,
        relief: &Relief,
    ) {
        let Some(images) = &target.relief else { return };
        let mut pass = target.begin_pass(recorder, "relief", images, None);
        gbuffer::draw(&mut pass, &self.pipeline, target, scene, |pass, range| {
            let group = relief.group(scene.materials.number(range.material));
            if let Some(group) = group {
                pass.set_bind_group(layout::GROUP_PASS, group, &[]);
            }
            group.is_some()
        });
    }
}
