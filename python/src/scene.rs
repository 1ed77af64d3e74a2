//! Scenes that have been loaded.

use crate::arguments::{RenderOptions, variables};
use crate::fault::{Fault, to_json};
use crate::picture::Picture;
use crate::rays::{self, RayArrays};
use crate::render::Under;
use crate::watched::watched;
use bhs::lang::source::FileCache;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap, Variables};
use bhs::registry::Registry;
use bhs::{diagnosis, report};
use bhs_core::diagnostics::Diagnostic;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Where the text of a scene comes from.
#[derive(Clone)]
pub enum Origin {
    /// A file.
    File(PathBuf),
    /// A text, whose relative paths start from the current folder.
    Text(Arc<str>),
}

/// Makes a scene, the same one as often as it is wanted.
#[derive(Clone)]
pub struct Maker {
    /// Where its text comes from.
    pub origin: Origin,
    variables: Variables,
    /// Meshes and pictures that have been read.
    cache: Arc<FileCache>,
}

impl Maker {
    /// The scene as `overrides` change it.
    pub fn make(&self, overrides: Overrides) -> Result<Made, Fault> {
        let overrides = Overrides { variables: self.variables.clone(), ..overrides };
        let registry = Registry::builtin();
        let mut sources = SourceMap::new().keeping(&self.cache);
        let built = match &self.origin {
            Origin::File(path) => lang::load(path, &registry, &overrides, &mut sources),
            Origin::Text(text) => lang::load_text("<text>", text, &registry, &overrides, &mut sources),
        };
        let mut built = built.map_err(|found| Fault::of_scene(&found, &sources))?;
        let found = diagnosis::before(&built);
        built.warnings.extend(found);
        let (of_picture, of_scene): (Vec<Diagnostic>, _) =
            built.warnings.iter().cloned().partition(diagnosis::is_about_the_picture);
        let drawn = |found: &[Diagnostic]| report::render(found, &sources, false).trim_end().to_owned();
        let of_picture = of_picture.chunks(1).map(drawn).collect();
        Ok(Made { of_scene: (drawn(&of_scene), to_json(&of_scene, &sources)), of_picture, built })
    }
}

/// A scene, and what the user should know.
pub struct Made {
    /// The scene.
    pub built: BuiltScene,
    /// Of the scene: as text, and as JSON objects.
    pub of_scene: (String, Vec<String>),
    /// Of its picture, which who follows rays need not care about.
    pub of_picture: Vec<String>,
}

/// A scene that has been loaded.
#[pyclass(frozen)]
pub struct Scene {
    maker: Maker,
    made: Arc<Made>,
}

#[pymethods]
impl Scene {
    /// Loads the file `path`, or the text `text`.
    #[new]
    fn new(py: Python, path: Option<PathBuf>, text: Option<&str>, definitions: BTreeMap<String, f64>) -> PyResult<Self> {
        let origin = match (path, text) {
            (Some(path), _) => Origin::File(path),
            (None, text) => Origin::Text(text.unwrap_or_default().into()),
        };
        let maker = Maker { origin, variables: variables(&definitions)?, cache: Arc::default() };
        let of_thread = maker.clone();
        let overrides = Overrides { may_lack_camera: true, ..Overrides::default() };
        let made = watched(py, move || of_thread.make(overrides), || (), || Ok(()))??;
        Ok(Self { maker, made: Arc::new(made) })
    }

    /// What the user should know of it: as text, and as JSON objects.
    #[getter]
    fn warnings(&self) -> (String, Vec<String>) {
        self.made.of_scene.clone()
    }

    /// The names of its cameras.
    #[getter]
    fn cameras(&self) -> Vec<Option<&str>> {
        self.made.built.camera_names().collect()
    }

    /// Width and height of its picture (pixels).
    #[getter]
    fn resolution(&self) -> [u32; 2] {
        self.made.built.film.resolution()
    }

    /// Samples a pixel.
    #[getter]
    fn spp(&self) -> u32 {
        self.made.built.sampler.samples_per_pixel()
    }

    /// The seed.
    #[getter]
    fn seed(&self) -> u64 {
        self.made.built.seed
    }

    /// The name of the integrator of light rays.
    #[getter]
    fn integrator(&self) -> &str {
        &self.made.built.integrator_name
    }

    /// The variables that it reads and that were given.
    #[getter]
    fn variables(&self) -> BTreeMap<String, f64> {
        self.made.built.variables.iter().cloned().collect()
    }

    /// Name and place of each `Shape` directive.
    #[getter]
    fn shapes(&self) -> Vec<(String, String)> {
        let names = (0..).map_while(|index| Some(self.made.built.statements.shape(index)?.0.to_owned()));
        names.zip(self.made.built.statements.shape_places()).collect()
    }

    /// Renders a picture; `progress` is called now and then with how far it is.
    fn render(&self, py: Python, options: RenderOptions, progress: Option<Bound<PyAny>>) -> PyResult<Picture> {
        let under = Under::new(&self.maker, &self.made, options)?;
        let (of_thread, shown) = (under.clone(), under.clone());
        let tell = || progress.as_ref().map_or(Ok(()), |call| shown.tell(call));
        Ok(watched(py, move || of_thread.render(), || under.stop(), tell)??)
    }

    /// Follows rays; their columns.
    fn trace<'py>(
        &self,
        py: Python<'py>,
        rays: RayArrays<'py>,
        threads: Option<u32>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        rays::trace(py, &self.made, rays.asked()?, (threads, progress))
    }

    /// Follows the rays through the centres of pixels of a camera; their columns, with those of where they start.
    fn trace_pixels<'py>(
        &self,
        py: Python<'py>,
        pixels: PyReadonlyArray2<'py, u32>,
        camera: Option<String>,
        threads: Option<u32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let maker = self.maker.clone();
        let made = watched(py, move || maker.make(Overrides { camera, ..Overrides::default() }), || (), || Ok(()))??;
        rays::trace_pixels(py, &Arc::new(made), &pixels, threads)
    }

    /// The points of the way of one ray.
    fn path<'py>(&self, py: Python<'py>, rays: RayArrays<'py>) -> PyResult<Bound<'py, PyDict>> {
        rays::path(py, &self.made, rays.asked()?)
    }

    /// The geodesics between pairs of points.
    fn connect<'py>(
        &self,
        py: Python<'py>,
        from: PyReadonlyArray2<'py, f64>,
        to: PyReadonlyArray2<'py, f64>,
        threads: Option<u32>,
    ) -> PyResult<Bound<'py, PyDict>> {
        rays::connect(py, &self.made, (&from, &to), threads)
    }
}
