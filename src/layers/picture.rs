//! Layers of whole pictures.

use crate::image::{Picture, single_precision};
use bhs_engine::layer::{LayerFormat, Value};

/// A layer of a whole picture.
pub struct LayerPicture {
    /// The name of the layer.
    pub name: &'static str,
    /// What its numbers are.
    pub format: LayerFormat,
    /// Its values, row by row from the top; `None` where no ray has one.
    pub values: Vec<Option<Value>>,
}

impl Picture {
    /// The same picture with layers as further channels; 0 where a layer has no value.
    pub fn with_layers(self, layers: &[LayerPicture]) -> Self {
        if layers.is_empty() {
            return self;
        }
        let names = layers.iter().flat_map(|l| l.format.channels.iter().map(|c| (*c).to_owned()));
        let channels: Vec<String> = self.channels.iter().cloned().chain(names).collect();
        let mut data = Vec::with_capacity(self.size[0] * self.size[1] * channels.len());
        for (i, color) in self.data.chunks_exact(self.channels.len()).enumerate() {
            data.extend_from_slice(color);
            for LayerPicture { format, values, .. } in layers {
                data.extend(values[i].unwrap_or_default()[..format.channels.len()].iter().copied().map(single_precision));
            }
        }
        Self { channels, data, ..self }
    }
}
