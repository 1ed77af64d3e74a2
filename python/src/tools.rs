//! What needs no scene: pictures compared and developed, and the program itself.

use crate::arguments::LookWords;
use crate::fault::Fault;
use crate::picture::{Picture, Pixels, Shown, of_colours, shown};
use anyhow::{Context, Result};
use bhs::compare::Comparison;
use bhs::develop::{Content, input::Input};
use bhs::difference::Difference;
use bhs::{image, program};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;
use std::borrow::Cow;
use std::ffi::OsString;
use std::fs::File;
use std::path::PathBuf;

/// A picture: one that was rendered, an array of red, green and blue, or an EXR file.
#[derive(FromPyObject)]
pub enum AnyPicture<'py> {
    /// One that was rendered.
    Rendered(Bound<'py, Picture>),
    /// Rows of pixels.
    Array(PyReadonlyArray3<'py, f32>),
    /// An EXR file.
    File(PathBuf),
}

/// The same without Python.
enum Source {
    Picture(image::Picture),
    File(PathBuf),
}

impl AnyPicture<'_> {
    fn source(&self) -> Result<Source, Fault> {
        Ok(match self {
            Self::Rendered(picture) => Source::Picture(picture.get().finished.all_channels().into_owned()),
            Self::File(path) => Source::File(path.clone()),
            Self::Array(array) => {
                let &[height, width, 3] = array.shape() else {
                    return Err(Fault::new(format!("expected an array of shape (height, width, 3), found {:?}", array.shape())));
                };
                Source::Picture(of_colours([width, height], array.as_array().iter().copied().collect()))
            }
        })
    }
}

impl Source {
    fn read(self) -> Result<image::Picture> {
        match self {
            Self::Picture(picture) => Ok(picture),
            Self::File(path) => image::Picture::read_exr(&path),
        }
    }
}

/// Names and means of channels.
type Ratios = Vec<(String, f64)>;
/// MSE, relative MSE, PSNR, largest difference; ratios of means; FLIP of each pixel, if it is asked for; all in words.
type Compared<'py> = ([f64; 4], Ratios, Option<Bound<'py, PyArray2<f32>>>, String);

/// How far `a` is from the reference `b`.
#[pyfunction]
pub fn compare<'py>(py: Python<'py>, a: AnyPicture<'py>, b: AnyPicture<'py>, flip: bool) -> PyResult<Compared<'py>> {
    let (a, b) = (a.source()?, b.source()?);
    let work = move || -> Result<_, Fault> {
        let (a, b) = (a.read()?, b.read()?);
        let compared = bhs::compare::compare(&a, &b)?;
        Ok((compared, a.size, if flip { Difference::new(&a, &b) } else { None }))
    };
    let (compared, [width, height], difference) = crate::watched::watched(py, work, || (), || Ok(()))??;
    let mut said = compared.to_string();
    if let Some(difference) = &difference {
        said += &format!("mean FLIP            {:.6}\n", difference.mean_flip());
    }
    let Comparison { channels, mse, relative_mse, psnr, largest, mean_ratio } = compared;
    let flip = difference.map(|d| d.flip.into_pyarray(py).reshape([height, width])).transpose()?;
    Ok(([mse, relative_mse, psnr, largest], channels.into_iter().zip(mean_ratio).collect(), flip, said))
}

/// A picture as a screen shows it: see [`Picture`]'s own.
#[pyfunction]
pub fn develop<'py>(
    py: Python<'py>,
    picture: AnyPicture<'py>,
    look: LookWords,
    layer: Option<String>,
    false_color: bool,
) -> PyResult<Shown<'py>> {
    let changes = look.changes()?;
    let source = picture.source()?;
    let work = move || -> Result<Pixels, Fault> {
        match source {
            Source::Picture(picture) if layer.is_none() && !false_color => {
                Ok(shown(&Content::Colours(Cow::Owned(picture)), &changes.over(Default::default())))
            }
            Source::Picture(_) => {
                Err(Fault::new("an array has no layers: `layer` and `false_color` are for pictures and EXR files"))
            }
            Source::File(path) => {
                let opened = File::open(&path).with_context(|| format!("cannot read `{}`", path.display()))?;
                let input = Input::read(&path, opened)?;
                let (content, _) = match &layer {
                    Some(name) => input.layer(name, false_color)?,
                    None => input.picture()?,
                };
                Ok(shown(&content, &changes.over(input.look())))
            }
        }
    };
    Ok(crate::watched::watched(py, work, || (), || Ok(()))??.into_python(py))
}

/// Runs the program with these words, of which the first is its name, and ends the process.
#[pyfunction]
pub fn run(py: Python, words: Vec<OsString>) {
    let code = py.detach(|| program::run(&words));
    std::process::exit(i32::from(code));
}

/// The level of processors that this module was built for.
#[pyfunction]
pub fn vectors() -> &'static str {
    bhs::vectors::own()
}

/// The one of these levels that suits the processor, or that is asked for.
#[pyfunction]
#[allow(clippy::needless_pass_by_value)] // Python hands over what is its own
pub fn choose_vectors(asked: Option<String>, names: Vec<String>) -> PyResult<String> {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bhs::vectors::choose(asked.as_deref(), &names).map(str::to_owned).map_err(PyImportError::new_err)
}
