//! A scene around one shape: what a plugin needs to be built, and files that are in memory.
#![allow(dead_code, reason = "every test file uses a part of it")]

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::geometry::{Aabb, Analytic, WorldGeometry, WorldMesh};
use bhs_core::params::{Context, Files, Params, SpectrumSource};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

pub struct Memory(pub Vec<(&'static str, Vec<u8>)>);

impl Files for Memory {
    fn read(&self, path: &str, _: Span) -> Result<Vec<u8>, String> {
        let file = self.0.iter().find(|f| f.0 == path);
        file.map(|f| f.1.clone()).ok_or_else(|| "no such file".into())
    }
}

struct NoSpectra;

impl SpectrumSource for NoSpectra {
    fn build(&self, _: &Param, _: SpectrumRole, _: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        Err(vec![Diagnostic::error("test", "shapes have no spectra")])
    }
}

pub fn param(ty: ParamType, name: &str, values: Values) -> Param {
    let span = Span::default();
    Param { ty: Spanned::new(ty, span), name: Spanned::new(name.into(), span), values, span }
}

pub fn numbers(ty: ParamType, name: &str, values: &[f64]) -> Param {
    let whole = values.iter().all(|v| v.fract() == 0.0);
    param(ty, name, Values::Numbers { values: values.to_vec(), whole })
}

pub fn text(name: &str, value: &str) -> Param {
    param(ParamType::String, name, Values::Strings(vec![Spanned::new(value.into(), Span::default())]))
}

/// Where a shape stands.
pub struct Place {
    pub files: Memory,
    pub transform: DAffine3,
    pub reverse: bool,
}

impl Default for Place {
    fn default() -> Self {
        Self { files: Memory(Vec::new()), transform: DAffine3::IDENTITY, reverse: false }
    }
}

impl Place {
    pub fn at(transform: DAffine3) -> Self {
        Self { transform, ..Self::default() }
    }

    pub fn reversed(self) -> Self {
        Self { reverse: !self.reverse, ..self }
    }

    /// Builds a shape; also what was said: messages with the words under them.
    pub fn build(&self, shape: &str, params: &[Param]) -> (Option<WorldGeometry>, Vec<String>) {
        let (mut surfaces, said) = self.build_all(shape, params);
        assert!(surfaces.len() <= 1, "{} surfaces", surfaces.len());
        (surfaces.pop(), said)
    }

    fn build_all(&self, shape: &str, params: &[Param]) -> (Vec<WorldGeometry>, Vec<String>) {
        let plugin = bhs_shapes::ALL.iter().find(|p| p.name == shape).expect("the shape exists");
        let context = Context {
            files: &self.files,
            spectra: &NoSpectra,
            named: &bhs_core::params::Nameless,
            world_from_object: self.transform,
            reverse_orientation: self.reverse,
            resolution: [1, 1],
            lambda_range: [360.0, 830.0],
            seed: 0,
        };
        let p = Params::new(Spanned::new(shape.into(), Span::default()), params, context);
        let built = (plugin.build)(&p).map(|s| s.into_geometry());
        let say = |d: Diagnostic| match d.primary {
            Some(label) if !label.text.is_empty() => format!("{}: {}", d.message, label.text),
            _ => d.message,
        };
        (built.unwrap_or_default(), p.finish().0.into_iter().map(say).collect())
    }

    /// All surfaces of a shape.
    pub fn analytics(&self, shape: &str, params: &[Param]) -> Vec<Box<dyn Analytic>> {
        let (surfaces, said) = self.build_all(shape, params);
        assert!(said.is_empty(), "{said:?}");
        let formula = |g| match g {
            WorldGeometry::Analytic(surface) => surface,
            WorldGeometry::Mesh(_) => panic!("a mesh"),
        };
        surfaces.into_iter().map(formula).collect()
    }

    pub fn mesh(&self, shape: &str, params: &[Param]) -> WorldMesh {
        match self.build(shape, params) {
            (Some(WorldGeometry::Mesh(mesh)), said) if said.is_empty() => mesh,
            (_, said) => panic!("no mesh: {said:?}"),
        }
    }

    pub fn analytic(&self, shape: &str, params: &[Param]) -> Box<dyn Analytic> {
        match self.build(shape, params) {
            (Some(WorldGeometry::Analytic(surface)), said) if said.is_empty() => surface,
            (_, said) => panic!("no surface: {said:?}"),
        }
    }

    /// What was said about a shape that could not be built.
    pub fn faults(&self, shape: &str, params: &[Param]) -> Vec<String> {
        let (built, said) = self.build(shape, params);
        assert!(built.is_none() || !said.is_empty());
        said
    }
}

pub fn near(a: DVec3, b: DVec3, tolerance: f64) -> bool {
    (a - b).abs().max_element() <= tolerance
}

pub fn box_near(found: Aabb, min: [f64; 3], max: [f64; 3], tolerance: f64) -> bool {
    near(found.min, min.into(), tolerance) && near(found.max, max.into(), tolerance)
}
