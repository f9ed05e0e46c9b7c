//! What a picture is made of, pixel by pixel, for other programs: geometry, labels, parts of its light.

use gnomon_options::choices;
use gnomon_picture::RgbImage;
use gnomon_picture::exr::{Channel, Samples};
use gnomon_shaders::layout;

use crate::RenderError;
use crate::cryptomatte::{self, Labels};

choices! {
    /// A layer of a picture.
    ///
    /// Geometry layers (depth, normal, position, uv, motion, object, material) show what is seen through the middle of each pixel and are
    /// never mixed over an edge. The others are means over the pixel, as the picture is.
    #[derive(Hash)]
    pub enum Layer {
        /// Distance along the camera's axis in metres; infinite behind the scene.
        Depth = "depth",
        /// Shading normal in the world, with the normal map, towards the camera; 0 behind the scene.
        Normal = "normal",
        /// Base colour, without light; 0 behind the scene.
        Albedo = "albedo",
        /// Place in the world in metres; 0 behind the scene.
        Position = "position",
        /// Texture coordinates, the mesh's first set; 0 where it has none.
        Uv = "uv",
        /// Way in the picture since the frame before in pixels, to the right and down.
        Motion = "motion",
        /// Number of the scene's node plus 1; 0 behind the scene.
        Object = "object",
        /// Number of the material plus 1, the default material last; 0 behind the scene.
        Material = "material",
        /// Shares of each pixel by the scene's nodes, for Cryptomatte: hashes of their names, six at most.
        CryptoObject = "crypto-object",
        /// The same by materials.
        CryptoMaterial = "crypto-material",
        /// Share of each pixel that shows the scene.
        Alpha = "alpha",
        /// Share of the light on matte surfaces that shadows leave; 1 behind the scene.
        Shadow = "shadow",
        /// Radiance that matte surfaces reflect.
        Diffuse = "diffuse",
        /// Radiance that glossy surfaces reflect.
        Specular = "specular",
        /// Radiance by each light, and what else the picture is the sum of: ambient, emission, reflections, background.
        Lights = "lights",
    }
}

/// Where a layer comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LayerSource {
    /// What is seen, a LAYER constant.
    Seen(u32),
    /// The same through several places of each pixel, for mattes.
    Matte(u32),
    /// What is composed, a PART constant.
    Composed(u32),
    /// The same under the light of one group.
    Group { group: u32, part: u32 },
}

/// Layers to be drawn with a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerRequest {
    /// Which; one that is named twice is drawn once.
    pub layers: Vec<Layer>,
    /// Most layers that [`Layer::Lights`] makes of lights, at least 1: the scene's own lights and then those that give most have one each, the
    /// others share the last one.
    pub light_layers: usize,
}

impl LayerRequest {
    /// [`LayerRequest::light_layers`] where nobody says.
    pub const LIGHT_LAYERS: usize = 8;
}

impl From<&[Layer]> for LayerRequest {
    fn from(layers: &[Layer]) -> Self {
        Self { layers: layers.to_vec(), light_layers: Self::LIGHT_LAYERS }
    }
}

impl<const N: usize> From<&[Layer; N]> for LayerRequest {
    fn from(layers: &[Layer; N]) -> Self {
        layers.as_slice().into()
    }
}

impl From<&Self> for LayerRequest {
    fn from(request: &Self) -> Self {
        request.clone()
    }
}

impl Layer {
    /// None for those that consist of several, each with its own name.
    pub(crate) fn source(self) -> Option<LayerSource> {
        Some(match self {
            Self::Depth => LayerSource::Seen(layout::LAYER_DEPTH),
            Self::Normal => LayerSource::Seen(layout::LAYER_NORMAL),
            Self::Position => LayerSource::Seen(layout::LAYER_POSITION),
            Self::Uv => LayerSource::Seen(layout::LAYER_UV),
            Self::Motion => LayerSource::Seen(layout::LAYER_MOTION),
            Self::Object => LayerSource::Seen(layout::LAYER_OBJECT),
            Self::Material => LayerSource::Seen(layout::LAYER_MATERIAL),
            Self::CryptoObject => LayerSource::Matte(layout::LAYER_OBJECT),
            Self::CryptoMaterial => LayerSource::Matte(layout::LAYER_MATERIAL),
            Self::Alpha => LayerSource::Composed(layout::PART_ALPHA),
            Self::Albedo => LayerSource::Composed(layout::PART_ALBEDO),
            Self::Shadow => LayerSource::Composed(layout::PART_SHADOW),
            Self::Diffuse => LayerSource::Composed(layout::PART_DIFFUSE),
            Self::Specular => LayerSource::Composed(layout::PART_SPECULAR),
            Self::Lights => return None,
        })
    }

    /// Names of its channels in OpenEXR files, as compositing programs know them: Nuke takes `Z`, `N` and `P` for what they are. Each of the
    /// several layers of [`Layer::Lights`] has a name of its own.
    pub const fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Depth => &["Z"],
            Self::Normal => &["N.X", "N.Y", "N.Z"],
            Self::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Self::Position => &["P.X", "P.Y", "P.Z"],
            Self::Uv => &["uv.U", "uv.V"],
            Self::Motion => &["motion.X", "motion.Y"],
            Self::Object => &["object.X"],
            Self::Material => &["material.X"],
            Self::CryptoObject => cryptomatte::OBJECT_CHANNELS,
            Self::CryptoMaterial => cryptomatte::MATERIAL_CHANNELS,
            Self::Alpha => &["A"],
            Self::Shadow => &["shadow.R", "shadow.G", "shadow.B"],
            Self::Diffuse => &["diffuse.R", "diffuse.G", "diffuse.B"],
            Self::Specular => &["specular.R", "specular.G", "specular.B"],
            Self::Lights => &[],
        }
    }

    /// What its mattes are of.
    pub(crate) fn names(self, labels: &Labels) -> Option<&[String]> {
        match self {
            Self::CryptoObject => Some(&labels.objects),
            Self::CryptoMaterial => Some(&labels.materials),
            _ => None,
        }
    }

    /// Unit of its values; empty for shares, directions and labels.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Depth | Self::Position => "m",
            Self::Motion => "pixels",
            Self::Diffuse | Self::Specular | Self::Lights => "radiance",
            _ => "",
        }
    }

    /// What it is, in a line.
    pub fn summary(self) -> String {
        let choices = Self::choices();
        choices
            .into_iter()
            .find(|choice| choice.name == self.name())
            .map_or(String::new(), |choice| choice.summary.to_owned())
    }

    /// Whether its values are whole numbers.
    pub const fn is_label(self) -> bool {
        matches!(self, Self::Object | Self::Material)
    }
}

/// Layers that were drawn with one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderedLayers {
    /// Columns and rows of each, those of the picture.
    pub size: [u32; 2],
    /// In the order in which they were asked for, each once, but for the several of [`Layer::Lights`].
    pub layers: Vec<RenderedLayer>,
}

impl RenderedLayers {
    /// Channels of an OpenEXR file that holds the picture, too, as `R`, `G` and `B`; and texts for its header that tell what each layer is.
    pub fn with_picture(&self, picture: &RgbImage) -> (Vec<Channel>, Vec<(String, String)>) {
        let color = |name: &str, component: usize| Channel {
            name: name.to_owned(),
            samples: Samples::Floats(picture.texels().iter().map(|texel| texel[component]).collect()),
        };
        let mut channels: Vec<_> = ["R", "G", "B"].iter().zip(0..).map(|(name, i)| color(name, i)).collect();
        channels.extend(self.layers.iter().flat_map(RenderedLayer::planes));
        let about = |layer: &RenderedLayer| (format!("gnomon.{}", layer.layer.name()), layer.layer.summary());
        let mut attributes: Vec<_> = self.layers.iter().map(about).collect();
        attributes.dedup();
        attributes.extend(self.layers.iter().flat_map(|layer| layer.attributes.iter().cloned()));
        (channels, attributes)
    }

    /// The layer, if it was drawn; the first of those of [`Layer::Lights`].
    pub fn get(&self, layer: Layer) -> Option<&RenderedLayer> {
        self.layers.iter().find(|rendered| rendered.layer == layer)
    }
}

/// A layer, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedLayer {
    /// Which.
    pub layer: Layer,
    /// Names of its channels in OpenEXR files.
    pub channels: Vec<String>,
    /// Texts of an OpenEXR file's header that it needs, by their names.
    pub attributes: Vec<(String, String)>,
    /// Of `size[1]` rows from the top, of `size[0]` pixels from the left, of each channel.
    pub values: LayerValues,
}

/// Values of a layer.
#[derive(Clone, Debug, PartialEq)]
pub enum LayerValues {
    /// In the unit that [`Layer::unit`] says.
    Floats(Vec<f32>),
    /// Labels, see [`Layer::is_label`].
    Labels(Vec<u32>),
}

impl RenderedLayer {
    /// Its channels one after the other.
    pub fn planes(&self) -> impl Iterator<Item = Channel> {
        let count = self.channels.len();
        self.channels.iter().enumerate().map(move |(i, name)| {
            let samples = match &self.values {
                LayerValues::Floats(values) => {
                    Samples::Floats(values.iter().skip(i).step_by(count).copied().collect())
                }
                LayerValues::Labels(values) => {
                    Samples::Labels(values.iter().skip(i).step_by(count).copied().collect())
                }
            };
            Channel { name: name.clone(), samples }
        })
    }

    /// Without any pixel yet; `name` is that of one of several.
    pub(crate) fn empty(layer: Layer, name: Option<&str>, labels: &Labels) -> Self {
        Self {
            layer,
            attributes: layer
                .names(labels)
                .map_or(Vec::new(), |names| cryptomatte::attributes(layer.channels(), names)),
            channels: match name {
                Some(name) => ["R", "G", "B"].iter().map(|channel| format!("{name}.{channel}")).collect(),
                None => layer.channels().iter().map(|&name| name.to_owned()).collect(),
            },
            values: match layer.is_label() {
                true => LayerValues::Labels(Vec::new()),
                false => LayerValues::Floats(Vec::new()),
            },
        }
    }

    /// Adds pixels of a matte, of which several samples were drawn, four words each.
    pub(crate) fn extend_matte(&mut self, samples: &[&[[u32; 4]]], labels: &Labels) {
        let label = |words: &[u32; 4]| words[0];
        let samples: Vec<Vec<u32>> = samples.iter().map(|words| words.iter().map(label).collect()).collect();
        if let (Some(names), LayerValues::Floats(floats)) = (self.layer.names(labels), &mut self.values) {
            floats.extend(cryptomatte::mattes(&samples, names));
        }
    }

    /// Adds pixels, four words each.
    pub(crate) fn extend(&mut self, words: &[[u32; 4]]) {
        let count = self.channels.len();
        let words = words.iter().flat_map(|words| &words[..count]).copied();
        match &mut self.values {
            LayerValues::Labels(labels) => labels.extend(words),
            LayerValues::Floats(floats) => floats.extend(words.map(f32::from_bits)),
        }
    }

    /// A number that is none, or an infinite one beside depth, is no value of a layer.
    pub(crate) fn check(&self, adapter: &str) -> Result<(), RenderError> {
        let LayerValues::Floats(floats) = &self.values else { return Ok(()) };
        let is_value = |value: &&f32| value.is_finite() || (self.layer == Layer::Depth && !value.is_nan());
        match floats.iter().filter(|value| !is_value(value)).count() {
            0 => Ok(()),
            pixels => Err(RenderError::NotFinite { pixels, adapter: adapter.to_owned() }),
        }
    }
}
