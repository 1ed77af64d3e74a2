//! Layers of whole pictures.

use crate::image::{Picture, single_precision};
use bhs_engine::layer::{LayerFormat, Value};

/// A number as files keep it; -0 stands for none.
fn in_files(value: f64) -> f32 {
    single_precision(value) + 0.0
}

/// What files keep of a pixel of a layer, of three channels at most; -0 where there is no value.
pub fn numbers_in_files(value: Option<Value>) -> [f32; 3] {
    value.map_or([-0.0; 3], |value| value.map(in_files))
}

/// A layer of a whole picture.
pub struct LayerPicture {
    /// The name of the layer.
    pub name: &'static str,
    /// What its numbers are.
    pub format: LayerFormat,
    /// Its values, row by row from the top; `None` where no ray has one.
    pub values: Vec<Option<Value>>,
}

impl LayerPicture {
    /// The same with the numbers that files keep, so that what is made of them is made of files too.
    pub fn as_in_files(mut self) -> Self {
        self.values.iter_mut().flatten().flatten().for_each(|v| *v = f64::from(in_files(*v)));
        self
    }
}

impl Picture {
    /// The same picture with layers as further channels; -0 where a layer has no value, which is 0 for all who do not look at the sign, and no
    /// value of a layer.
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
                let own = numbers_in_files(values[i]);
                data.extend_from_slice(&own[..format.channels.len()]);
            }
        }
        Self { channels, data, ..self }
    }
}
