//! Files of any channels, as compositing programs take pictures apart.

use std::io::Cursor;
use std::path::Path;

use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage,
};

use crate::atomic;
use crate::error::ImageError;

/// A channel of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name, that of its layer before the last dot: `R`, `N.X`, `diffuse.G`.
    pub name: String,
    /// Row by row from the top, stored as they are.
    pub samples: Samples,
}

/// Samples of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 32-bit floats.
    Floats(Vec<f32>),
    /// 32-bit whole numbers.
    Labels(Vec<u32>),
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::Floats(samples) => samples.len(),
            Self::Labels(samples) => samples.len(),
        }
    }
}

/// Encodes channels of `size` texels as one part of an OpenEXR file: scanlines, ZIP. `attributes` are texts of its header, by their names.
///
/// # Errors
/// The reason: no texel or no channel, a channel of another size, two of one name, a name that is none.
pub fn encode_channels(
    [width, height]: [u32; 2],
    channels: Vec<Channel>,
    attributes: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let texels = width as usize * height as usize;
    if texels == 0 || channels.is_empty() {
        return Err("the picture is empty".to_owned());
    }
    let mut names: Vec<_> = channels.iter().map(|channel| channel.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("two channels are called '{}'", pair[0]));
    }
    if let Some(channel) = channels.iter().find(|channel| channel.samples.len() != texels) {
        let (name, count) = (&channel.name, channel.samples.len());
        return Err(format!("channel '{name}' has {count} texels, the picture {texels}"));
    }
    let text =
        |words: &str| Text::new_or_none(words).ok_or_else(|| format!("'{words}' is no text for a header"));
    let channel = |Channel { name, samples }: Channel| {
        let samples = match samples {
            Samples::Floats(samples) => FlatSamples::F32(samples),
            Samples::Labels(samples) => FlatSamples::U32(samples),
        };
        Ok(AnyChannel::new(text(&name)?, samples))
    };
    let list = channels.into_iter().map(channel).collect::<Result<_, String>>()?;
    let mut layer_attributes = LayerAttributes::default();
    for (name, value) in attributes {
        layer_attributes.other.insert(text(name)?, AttributeValue::Text(text(value)?));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (width as usize, height as usize);
    let layer = Layer::new(size, layer_attributes, encoding, AnyChannels::sort(list));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Writes channels as [`encode_channels`] stores them, whole or not at all.
///
/// # Errors
/// [`ImageError::Write`] from the file system, [`ImageError::Encode`] as [`encode_channels`].
pub fn write_channels(
    path: &Path,
    size: [u32; 2],
    channels: Vec<Channel>,
    attributes: &[(String, String)],
) -> Result<(), ImageError> {
    let bytes = encode_channels(size, channels, attributes)
        .map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, |writer| writer.write_all(&bytes))
        .map_err(|source| ImageError::Write { path: path.to_owned(), source })
}
