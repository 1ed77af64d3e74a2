//! Pictures that have been rendered.

use crate::arguments::LookWords;
use crate::fault::Fault;
use bhs::develop::{Content, Texts};
use bhs::finished::Finished;
use bhs::image::{self, Attribute};
use bhs::lang::BuiltScene;
use bhs::layers::numbers_in_files;
use bhs::look::Look;
use bhs::output::OutputFile;
use numpy::{IntoPyArray, PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// A picture that has been rendered.
#[pyclass(frozen)]
pub struct Picture {
    /// As it is written.
    pub finished: Finished,
    /// How it is shown.
    pub look: Look,
    attributes: Vec<(String, Attribute)>,
    notes: Vec<String>,
    stats: String,
}

impl Picture {
    /// That of a scene; `notes` are what the user should know of it, `stats` what it took, as JSON.
    pub fn new(built: &BuiltScene, finished: Finished, notes: Vec<String>, stats: String) -> Self {
        let attributes = finished.attributes(built);
        Self { finished, look: built.look, attributes, notes, stats }
    }

    fn write_png(&self, to: &mut impl std::io::Write) -> anyhow::Result<()> {
        self.finished.content(None, false)?.write(to, &self.look, &Texts::of_attributes(&self.attributes))
    }
}

#[pymethods]
impl Picture {
    /// All channels of its EXR file by their names, each as rows of numbers.
    fn channels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = py.detach(|| self.finished.all_channels().into_owned());
        let [width, height] = all.size;
        let channels = PyDict::new(py);
        for (c, name) in all.channels.iter().enumerate() {
            let values: Vec<f32> = all.data.iter().skip(c).step_by(all.channels.len()).copied().collect();
            channels.set_item(name, values.into_pyarray(py).reshape([height, width])?)?;
        }
        Ok(channels)
    }

    /// Linear red, green and blue.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let picture = &self.finished.picture;
        let [width, height] = picture.size;
        let colours: Vec<f32> = py.detach(|| picture.pixels().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect());
        colours.into_pyarray(py).reshape([height, width, 3])
    }

    /// The layers by their names, each with its unit; NaN where there is no value.
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let [width, height] = self.finished.picture.size;
        let layers = PyDict::new(py);
        for layer in &self.finished.layers {
            let channels = layer.format.channels.len();
            let numbers = |value: &Option<_>| value.map_or([f32::NAN; 3], |value| numbers_in_files(Some(value)));
            let values: Vec<f32> = layer.values.iter().flat_map(|value| numbers(value).into_iter().take(channels)).collect();
            layers.set_item(layer.name, (values.into_pyarray(py).reshape([height, width, channels])?, layer.format.unit))?;
        }
        Ok(layers)
    }

    /// What the user should know of it.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// What it took, as JSON.
    #[getter]
    fn stats(&self) -> &str {
        &self.stats
    }

    /// Its PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let written = py.detach(|| {
            let mut bytes = Vec::new();
            self.write_png(&mut bytes).map(|()| bytes)
        });
        Ok(PyBytes::new(py, &written.map_err(Fault::from)?))
    }

    /// Writes its EXR or PNG file.
    fn save(&self, py: Python, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let written = py.detach(|| match ending.as_deref() {
            Some("exr") => OutputFile::reserve(&path)?.finish(|to| self.finished.all_channels().write_exr(to, &self.attributes)),
            Some("png") => OutputFile::reserve(&path)?.finish(|to| self.write_png(to)),
            _ => Err(anyhow::anyhow!("cannot write `{}`: the name of a picture ends in .exr or .png", path.display())),
        });
        Ok(written.map_err(Fault::from)?)
    }

    /// Its colours, or a layer, as a screen shows them: bytes or, with 16 bits, big-endian pairs of them, and width and height.
    fn develop<'py>(&self, py: Python<'py>, look: LookWords, layer: Option<&str>, false_color: bool) -> PyResult<Shown<'py>> {
        let look = look.changes()?.over(self.look);
        let shown = py.detach(|| self.finished.content(layer, false_color).map(|content| shown(&content, &look)));
        Ok(shown.map_err(Fault::from)?.into_python(py))
    }
}

/// Bytes, width and height, and bytes of a number.
pub type Shown<'py> = (Bound<'py, PyArray1<u8>>, [usize; 2], usize);

/// A picture as a screen shows it.
pub struct Pixels {
    bytes: Vec<u8>,
    size: [usize; 2],
}

/// What a PNG file of it would show.
pub fn shown(content: &Content, look: &Look) -> Pixels {
    Pixels { bytes: content.pixels(look), size: content.size() }
}

impl Pixels {
    /// For Python.
    pub fn into_python(self, py: Python<'_>) -> Shown<'_> {
        let numbers = 3 * self.size[0] * self.size[1];
        let width = self.bytes.len() / numbers.max(1);
        (self.bytes.into_pyarray(py), self.size, width)
    }
}

/// An array of red, green and blue as a picture.
pub fn of_colours(size: [usize; 2], data: Vec<f32>) -> image::Picture {
    let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
    image::Picture { size, frame: image::Frame { offset: [0, 0], size }, channels, data }
}
