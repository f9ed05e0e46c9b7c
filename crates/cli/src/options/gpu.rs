//! Options of everything that draws on the GPU.

use clap::{Args, ValueEnum};
use gnomon::studio::{self, Look};

use crate::options::FitArgs;

/// How the GPU draws. What is not given is the scene file's, or else the default.
#[derive(Args, Clone, Debug)]
pub struct GpuArgs {
    /// How to fit lights to the environment: disks, squares, rectangles, partition, optimized, samples (see gnomon info), or
    /// none for ambient light only [default: optimized]
    #[arg(long, value_name = "METHOD")]
    lights: Option<String>,

    #[command(flatten)]
    pub fit: FitArgs,

    /// Shadow technique: pcss, convolution, moments, pcf, hard, hard-linear or none [default: pcss]
    #[arg(long, value_name = "NAME")]
    shadows: Option<String>,

    /// How shadows and unshadowed light become one picture: ratio, subtractive or additive [default: ratio]
    #[arg(long, value_name = "NAME")]
    compositing: Option<String>,

    /// Where unshadowed light comes from: auto (irradiance map, prefiltered environment, radiance cache, by material), sh (nine
    /// spherical harmonics for matte surfaces) or cache (a radiance cache for every glossy material) [default: auto]
    #[arg(long, value_name = "NAME")]
    unshadowed: Option<String>,

    /// Texels along each side of a light's shadow map, a power of two [default: 256]
    #[arg(long, value_name = "N")]
    shadow_resolution: Option<u32>,

    /// Terms of the series that convolution shadows are made of, 1 to 16: more tell blockers apart that are closer to the receiver,
    /// and cost time and memory for every four [default: 4]
    #[arg(long, value_name = "M")]
    order: Option<u32>,

    /// How convolution shadows are filtered: mip chains (half floats), or summed-area tables (32-bit floats; a rectangle's kernel has
    /// its own width and height) [default: mip]
    #[arg(long, value_enum)]
    prefilter: Option<PrefilterName>,

    /// Places of the depth map that convolution shadows look at for blockers too near for the series, 0 to 64; 0 leaves contacts to the
    /// series and its sharpening, as the paper does [default: 8]
    #[arg(long, value_name = "N")]
    contact_samples: Option<u32>,

    /// How large the lights' shadow maps are: by the light's footprint, wide lights having coarser maps, or all alike [default: footprint]
    #[arg(long, value_enum)]
    shadow_sizing: Option<SizingName>,

    /// Memory for shadow maps and their images in MiB; lights that do not fit take turns [default: 1024]
    #[arg(long, value_name = "MIB")]
    shadow_memory: Option<u32>,

    /// Texels by which simpler meshes, drawn into the shadow maps of wide lights in place of those of many triangles, may deviate from
    /// them, 0 to 16; 0 draws all triangles [default: 0.25]
    #[arg(long, value_name = "TEXELS")]
    caster_deviation: Option<f32>,

    /// What the ambient rest of a fit does about shadows: cells (lights of its own), occlusion or unshadowed [default: cells]
    #[arg(long, value_name = "NAME")]
    ambient: Option<String>,

    /// Most lights or probes that the ambient rest may become, 6 to 4096 [default: 32]
    #[arg(long, value_name = "N")]
    ambient_cells: Option<usize>,

    /// Samples along each side of a pixel, 1 to 8 [default: 2]
    #[arg(long, value_name = "N")]
    supersample: Option<u32>,

    /// Samples along each side of a tile over which lights are summed once: 1, 2, 4, 8, 16 or 32. Samples unlike the tiles around
    /// them are lit by themselves, so that edges stay sharp [default: 2]
    #[arg(long, value_name = "N")]
    shadow_sampling: Option<u32>,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

/// Names of [`studio::PrefilterName`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PrefilterName {
    /// Mip chains
    Mip,
    /// Summed-area tables
    Sat,
}

impl From<PrefilterName> for studio::PrefilterName {
    fn from(name: PrefilterName) -> Self {
        match name {
            PrefilterName::Mip => Self::Mip,
            PrefilterName::Sat => Self::Sat,
        }
    }
}

/// Names of [`studio::SizingName`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SizingName {
    /// The wider the light, the coarser its map
    Footprint,
    /// All alike
    Uniform,
}

impl From<SizingName> for studio::SizingName {
    fn from(name: SizingName) -> Self {
        match name {
            SizingName::Footprint => Self::Footprint,
            SizingName::Uniform => Self::Uniform,
        }
    }
}

impl GpuArgs {
    /// Changes what the options mention.
    pub fn apply(&self, look: &mut Look) {
        fn set<T: Clone>(value: &mut T, option: &Option<T>) {
            if let Some(option) = option {
                value.clone_from(option);
            }
        }
        set(&mut look.fit.method, &self.lights);
        self.fit.apply(&mut look.fit);
        let render = &mut look.render;
        set(&mut render.shadows, &self.shadows);
        set(&mut render.compositing, &self.compositing);
        set(&mut render.unshadowed, &self.unshadowed);
        set(&mut render.shadow_resolution, &self.shadow_resolution);
        set(&mut render.order, &self.order);
        set(&mut render.contact_samples, &self.contact_samples);
        set(&mut render.shadow_memory, &self.shadow_memory);
        set(&mut render.caster_deviation, &self.caster_deviation);
        set(&mut render.ambient, &self.ambient);
        set(&mut render.ambient_cells, &self.ambient_cells);
        set(&mut render.supersample, &self.supersample);
        set(&mut render.shadow_sampling, &self.shadow_sampling);
        set(&mut render.prefilter, &self.prefilter.map(Into::into));
        set(&mut render.shadow_sizing, &self.shadow_sizing.map(Into::into));
    }
}
