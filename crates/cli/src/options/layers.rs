use std::path::Path;

use clap::Args;
use gnomon::renderer::layers::{Layer, LayerRequest};

use crate::error::CliError;
use crate::output;

/// What is written beside the picture. It changes no picture, and so is no part of a look.
#[derive(Args, Clone, Debug)]
pub struct LayerArgs {
    /// Write layers into the picture's OpenEXR file, several with commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = layer, long_help = help(), conflicts_with = "debug")]
    layers: Vec<Layer>,

    /// Most layers that --layers lights makes of lights: the scene's own and those that give most have one each, the others share the last
    /// [default: 8]
    #[arg(long, value_name = "N", requires = "layers", value_parser = clap::value_parser!(u32).range(1..=1024))]
    light_layers: Option<u32>,
}

fn help() -> String {
    let choices = Layer::choices();
    let width = choices.iter().map(|layer| layer.name.len()).max().unwrap_or(0) + 2;
    let lines = choices.into_iter().map(|layer| format!("\n  {:<width$}{}", layer.name, layer.summary));
    format!("Write layers into the picture's OpenEXR file, several with commas:{}", lines.collect::<String>())
}

fn layer(text: &str) -> Result<Layer, String> {
    let names = || Layer::ALL.iter().map(|layer| layer.name()).collect::<Vec<_>>().join(", ");
    Layer::from_name(text.trim()).ok_or_else(|| format!("choose from: {}", names()))
}

impl LayerArgs {
    /// The layers, for pictures that go to `path`.
    ///
    /// # Errors
    /// [`CliError::Usage`] for a file that holds none, and for motion where there is one picture only.
    pub fn request(&self, path: &Path, is_sequence: bool) -> Result<LayerRequest, CliError> {
        if !self.layers.is_empty() && !output::is_linear(path) {
            return Err(CliError::usage(
                "--layers needs a picture that can hold them: a name ending in .exr",
            ));
        }
        if self.layers.contains(&Layer::Motion) && !is_sequence {
            return Err(CliError::usage(
                "layer motion is the way since the frame before: say which frames with --frames or --duration",
            ));
        }
        let light_layers = self.light_layers.map_or(LayerRequest::LIGHT_LAYERS, |count| count as usize);
        Ok(LayerRequest { layers: self.layers.clone(), light_layers })
    }
}
