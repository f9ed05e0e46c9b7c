//! Which channels of a file are its picture.

use ::exr::meta::header::Header;
use gnomon_messages::quoted;

use crate::error::DecodeError;

/// Last parts of the names that programs give to the layer of the finished picture, the plainest first. Blender's compositor comes before
/// the view layers that it is fed with.
const FINISHED: [&str; 8] =
    ["composite.combined", "combined", "beauty", "rgba", "rgb", "rgb_color", "color", "main"];
/// Most names in a message.
const MOST_TOLD: usize = 24;

/// Channels of one part by their index, and what they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channels {
    Rgb([usize; 3]),
    /// Luminance, and red and blue less luminance over luminance.
    LuminanceChroma([usize; 3]),
    Grey(usize),
}

/// What is read of a file.
#[derive(Debug)]
pub(super) struct Choice {
    pub part: usize,
    pub channels: Channels,
    pub details: Vec<String>,
    pub warnings: Vec<String>,
}

/// Channels of one part whose names begin alike up to the last dot.
struct Layer {
    part: usize,
    /// Name of the part where there are several, and what the channels' names begin with.
    part_name: String,
    prefix: String,
    /// Last parts of the channels' names, and their indices.
    channels: Vec<(String, usize)>,
}

impl Layer {
    fn name(&self) -> String {
        match (self.part_name.as_str(), self.prefix.as_str()) {
            (part, "") => part.to_owned(),
            ("", prefix) => prefix.to_owned(),
            // Blender repeats the part's name in those of its channels.
            (part, prefix) if prefix.starts_with(part) => prefix.to_owned(),
            (part, prefix) => format!("{part}.{prefix}"),
        }
    }

    fn is_called(&self, name: &str) -> bool {
        [&self.name(), &self.prefix, &self.part_name].into_iter().any(|own| own.eq_ignore_ascii_case(name))
    }

    fn find(&self, names: &[&str]) -> Option<usize> {
        let is = |channel: &str| names.iter().any(|name| channel.eq_ignore_ascii_case(name));
        self.channels.iter().find(|(channel, _)| is(channel)).map(|&(_, index)| index)
    }

    fn rgb(&self) -> Option<Channels> {
        let [r, g, b] = [["r", "red"], ["g", "green"], ["b", "blue"]].map(|names| self.find(&names));
        Some(Channels::Rgb([r?, g?, b?]))
    }

    fn luminance(&self) -> Option<Channels> {
        let y = self.find(&["y"])?;
        Some(match (self.find(&["ry"]), self.find(&["by"])) {
            (Some(ry), Some(by)) => Channels::LuminanceChroma([y, ry, by]),
            _ => Channels::Grey(y),
        })
    }

    fn colors(&self) -> Option<Channels> {
        self.rgb().or_else(|| self.luminance())
    }

    /// Whole name of a channel.
    fn channel_name(&self, channel: &str) -> String {
        match self.name().as_str() {
            "" => channel.to_owned(),
            layer => format!("{layer}.{channel}"),
        }
    }

    /// How plainly it is the finished picture; the lowest is.
    fn rank(&self) -> Option<usize> {
        let name = self.name().to_ascii_lowercase();
        let ends =
            |with: &&str| name.strip_suffix(*with).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'));
        match name.is_empty() {
            true => Some(0),
            false => FINISHED.iter().position(ends).map(|position| position + 1),
        }
    }
}

fn layers(parts: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, header) in parts.iter().enumerate() {
        // A part that is alone needs no name.
        let name = header.own_attributes.layer_name.as_ref().filter(|_| parts.len() > 1);
        let part_name = name.map(|name| name.to_string()).unwrap_or_default();
        for (index, channel) in header.channels.list.iter().enumerate() {
            let name = channel.name.to_string();
            let (prefix, channel) = name.rsplit_once('.').unwrap_or(("", &name));
            let channel = (channel.to_owned(), index);
            match layers.iter_mut().find(|layer| layer.part == part && layer.prefix == prefix) {
                Some(layer) => layer.channels.push(channel),
                None => layers.push(Layer {
                    part,
                    part_name: part_name.clone(),
                    prefix: prefix.to_owned(),
                    channels: vec![channel],
                }),
            }
        }
    }
    layers
}

/// What `names` are, for a message.
fn told(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    let mut list = names.iter().take(MOST_TOLD).map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    if names.len() > MOST_TOLD {
        list += &format!(" and {} more", names.len() - MOST_TOLD);
    }
    list
}

/// The layer that is called so, or else the one that is plainly the picture.
pub(super) fn choose(parts: &[Header], asked: Option<&str>) -> Result<Choice, DecodeError> {
    let layers = layers(parts);
    match asked {
        Some(name) => named(&layers, name),
        None => plain(&layers),
    }
}

fn choice(layer: &Layer, channels: Channels) -> Choice {
    let name = layer.name();
    let details = if name.is_empty() { Vec::new() } else { vec![format!("layer '{}'", quoted(&name))] };
    let warnings = match channels {
        Channels::Grey(index) => {
            let channel =
                layer.channels.iter().find(|&&(_, own)| own == index).map(|(name, _)| name.as_str());
            vec![format!(
                "only channel '{}' is read, as grey",
                quoted(&layer.channel_name(channel.unwrap_or_default()))
            )]
        }
        _ => Vec::new(),
    };
    Choice { part: layer.part, channels, details, warnings }
}

/// A layer by its name, or one channel by its whole name.
fn named(layers: &[Layer], name: &str) -> Result<Choice, DecodeError> {
    let called = || layers.iter().filter(|layer| layer.is_called(name));
    let colored = called().find_map(|layer| Some((layer, layer.colors()?)));
    let alone = || {
        called().find_map(|layer| match layer.channels.as_slice() {
            &[(_, index)] => Some((layer, Channels::Grey(index))),
            _ => None,
        })
    };
    let channel = || {
        layers.iter().find_map(|layer| {
            let is = |channel: &str| layer.channel_name(channel).eq_ignore_ascii_case(name);
            let &(_, index) = layer.channels.iter().find(|(channel, _)| is(channel))?;
            Some((layer, Channels::Grey(index)))
        })
    };
    let found = colored.or_else(alone).or_else(channel);
    found.map(|(layer, channels)| choice(layer, channels)).ok_or_else(|| {
        let colored = layers.iter().filter(|layer| layer.colors().is_some());
        let known = match colored.clone().count() {
            0 => told(all_channels(layers)),
            _ => told(colored.map(Layer::name)),
        };
        DecodeError::NoLayer { name: name.to_owned(), known }
    })
}

fn plain(layers: &[Layer]) -> Result<Choice, DecodeError> {
    let rgb: Vec<_> = layers.iter().filter_map(|layer| Some((layer, layer.rgb()?))).collect();
    if !rgb.is_empty() {
        return plainest(&rgb);
    }
    let luminance: Vec<_> = layers.iter().filter_map(|layer| Some((layer, layer.luminance()?))).collect();
    if !luminance.is_empty() {
        return plainest(&luminance);
    }
    match layers {
        [layer] if layer.channels.len() == 1 => Ok(choice(layer, Channels::Grey(layer.channels[0].1))),
        [] => Err(DecodeError::unsupported(super::FORMAT, "it holds no channel")),
        _ => Err(DecodeError::NoPlainLayer {
            layers: format!("no red, green and blue among {}", told(all_channels(layers))),
        }),
    }
}

/// The layer that is plainly the picture, of those that hold colours.
fn plainest(layers: &[(&Layer, Channels)]) -> Result<Choice, DecodeError> {
    let best = layers.iter().filter_map(|(layer, _)| layer.rank()).min();
    let of_best: Vec<_> = layers.iter().filter(|(layer, _)| best.is_some() && layer.rank() == best).collect();
    if let ([(layer, channels)], _) | (_, [(layer, channels)]) = (layers, of_best.as_slice()) {
        return Ok(choice(layer, *channels));
    }
    // Of several parts the first with colours of its own is what the format's own readers take.
    if let Some((layer, channels)) =
        layers.iter().find(|(layer, _)| layer.prefix.is_empty() && !layer.part_name.is_empty())
    {
        let mut choice = choice(layer, *channels);
        let all = told(layers.iter().map(|(layer, _)| layer.name()));
        choice.warnings.push(format!("layer '{}' is read, the first of {all}", quoted(&layer.name())));
        return Ok(choice);
    }
    Err(DecodeError::NoPlainLayer { layers: told(layers.iter().map(|(layer, _)| layer.name())) })
}

fn all_channels(layers: &[Layer]) -> impl Iterator<Item = String> {
    layers.iter().flat_map(|layer| layer.channels.iter().map(|(channel, _)| layer.channel_name(channel)))
}
