//! Pictures and their layers as arrays.

use gnomon::picture::RgbImage;
use gnomon::renderer::layers::{Layer, LayerValues, RenderedLayers};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::error::refused;

/// Values of pictures, one after another, as one array.
struct Stack {
    name: String,
    channels: usize,
    values: LayerValues,
}

/// The picture and layers of one picture after another.
#[derive(Default)]
pub struct Pictures(Vec<Stack>);

impl Pictures {
    /// Takes a picture over.
    pub fn add(&mut self, radiance: &RgbImage, layers: RenderedLayers) {
        let texels = radiance.texels().iter().flat_map(|texel| texel.to_array()).collect();
        self.extend("radiance".to_owned(), 3, LayerValues::Floats(texels));
        for layer in layers.layers {
            let name = match (layer.layer, layer.channels.first()) {
                // There are several, which their channels tell apart.
                (Layer::Lights, Some(channel)) => channel.trim_end_matches(".R").to_owned(),
                (layer, _) => layer.name().to_owned(),
            };
            self.extend(name, layer.channels.len(), layer.values);
        }
    }

    fn extend(&mut self, name: String, channels: usize, values: LayerValues) {
        let known = self.0.iter_mut().find(|stack| stack.name == name);
        match (known.map(|stack| &mut stack.values), values) {
            (Some(LayerValues::Floats(all)), LayerValues::Floats(more)) => all.extend(more),
            (Some(LayerValues::Labels(all)), LayerValues::Labels(more)) => all.extend(more),
            (_, values) => self.0.push(Stack { name, channels, values }),
        }
    }

    /// The picture's array, or with layers a dict of arrays; their shape begins with `shape`.
    pub fn arrays<'py>(
        &self,
        py: Python<'py>,
        shape: &[usize],
        has_layers: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let named = PyDict::new(py);
        for Stack { name, channels, values } in &self.0 {
            let mut shape = shape.to_vec();
            shape.extend((*channels > 1).then_some(*channels));
            let length = match values {
                LayerValues::Floats(values) => values.len(),
                LayerValues::Labels(values) => values.len(),
            };
            if length != shape.iter().product::<usize>() {
                return Err(refused(format!("not all pictures have a layer '{name}': draw them one by one")));
            }
            let array = match values {
                LayerValues::Floats(values) => arrays::floats(py, values, &shape)?,
                LayerValues::Labels(values) => {
                    arrays::array(py, bytemuck::cast_slice(values), "uint32", &shape)?
                }
            };
            if !has_layers {
                return Ok(array);
            }
            named.set_item(name, array)?;
        }
        Ok(named.into_any())
    }
}

/// Layers by their names; not that of motion, as there is no frame before.
pub fn layers_named(names: Option<Vec<String>>) -> PyResult<Vec<Layer>> {
    let layer = |name: &String| {
        Layer::from_name(name).filter(|layer| *layer != Layer::Motion).ok_or_else(|| {
            let known = Layer::ALL.iter().filter(|layer| **layer != Layer::Motion).map(|layer| layer.name());
            refused(format!(
                "there is no layer '{}'; there are: {}",
                quoted(name),
                known.collect::<Vec<_>>().join(", ")
            ))
        })
    };
    names.iter().flatten().map(layer).collect()
}
