//! All plugins by kind, and the one way to make them from a scene.
//!
//! The crates' lists are named here, explicitly. A plugin from outside the tree joins with [`Registry::with`]:
//!
//! ```ignore
//! let registry = Registry::builtin().with(my_crate::PLUGIN);
//! ```

use crate::lang::description::Entity;
use crate::{advice, glossary};
use bhs_core::Plugin;
use bhs_core::camera::{Camera, Film, Filter, Viewpoint};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean, shorten};
use bhs_core::geometry::Shape;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::light::{AreaLight, Light};
use bhs_core::material::Material;
use bhs_core::motion::{Motion, read_motion};
use bhs_core::observer::Conventions;
use bhs_core::params::{Context, Files, Nameless, ParamInfo, Params, SpectrumMaker, SpectrumSource};
use bhs_core::sampling::Sampler;
use bhs_core::spacetime::Spacetime;
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::texture::Texture;
use bhs_core::value::{Param, Values};
use bhs_engine::integrator::IntegratorBuilder;
use bhs_engine::layer::{Layer, LayerFormat, NamedLayer, read_layers};
use bhs_engine::transport::LightTransport;
use bhs_materials::bumps::Bumps;
use glam::DAffine3;
use std::sync::Arc;

/// A kind of plugin: the trait object that its plugins make.
pub trait Kind: 'static {
    /// What the language reference calls it.
    const WORD: &'static str;
    /// Its plugins.
    fn list(registry: &Registry) -> &[Plugin<Self>];
}

macro_rules! kinds {
    ($($field:ident: $variant:ident($ty:ty) = $word:literal, $list:expr;)*) => {
        /// All plugins.
        pub struct Registry {
            $($field: Vec<Plugin<$ty>>,)*
        }

        /// A plugin of any kind.
        #[derive(Clone, Copy)]
        pub enum AnyPlugin {
            $(#[doc = concat!("A plugin of the kind \"", $word, "\".")] $variant(Plugin<$ty>),)*
        }

        $(
            impl Kind for $ty {
                const WORD: &'static str = $word;
                fn list(registry: &Registry) -> &[Plugin<Self>] {
                    &registry.$field
                }
            }

            impl From<Plugin<$ty>> for AnyPlugin {
                fn from(plugin: Plugin<$ty>) -> Self {
                    Self::$variant(plugin)
                }
            }
        )*

        impl Registry {
            /// The plugins of the tree.
            pub fn builtin() -> Self {
                Self { $($field: $list.to_vec(),)* }
            }

            /// No plugins but the spectra: for a program that makes its own choice by [`Registry::with`].
            pub fn empty() -> Self {
                Self { spectra: bhs_spectra::ALL.to_vec(), ..Self { $($field: Vec::new(),)* } }
            }

            /// Adds a plugin; one of the same kind and name is replaced.
            pub fn with(mut self, plugin: impl Into<AnyPlugin>) -> Self {
                match plugin.into() {
                    $(AnyPlugin::$variant(plugin) => {
                        self.$field.retain(|p| p.name != plugin.name);
                        self.$field.push(plugin);
                    })*
                }
                self
            }

            /// What there is: all plugins of all kinds, with their parameters.
            pub fn describe(&self) -> Vec<PluginInfo> {
                let mut all = Vec::new();
                $(all.extend(<$ty as Kind>::list(self).iter().map(|p| self.describe_one(p)));)*
                all
            }

            /// The names of the kinds, in the order of [`Registry::describe`].
            pub const KINDS: &'static [&'static str] = &[$($word),*];
        }
    };
}

kinds! {
    integrators: Integrator(dyn IntegratorBuilder) = "integrator", bhs_integrators::ALL;
    transports: Transport(dyn LightTransport) = "light transport", bhs_transports::ALL;
    intersectors: Intersector(dyn IntersectorBuilder) = "intersector", bhs_intersectors::ALL;
    cameras: Camera(dyn Camera) = "camera", bhs_cameras::ALL;
    films: Film(dyn Film) = "film", bhs_films::ALL;
    filters: Filter(dyn Filter) = "filter", bhs_filters::ALL;
    samplers: Sampler(dyn Sampler) = "sampler", bhs_samplers::ALL;
    materials: Material(dyn Material) = "material", bhs_materials::ALL;
    textures: Texture(dyn Texture) = "texture", bhs_textures::ALL;
    lights: Light(dyn Light) = "light", bhs_lights::ALL;
    area_lights: AreaLight(dyn AreaLight) = "area light", bhs_lights::AREA;
    spacetimes: Spacetime(dyn Spacetime) = "spacetime", bhs_spacetimes::ALL;
    motions: Motion(dyn Motion) = "motion", bhs_motions::ALL;
    shapes: Shape(dyn Shape) = "shape", bhs_shapes::ALL;
    spectra: Spectrum(dyn SpectrumMaker) = "spectrum", bhs_spectra::ALL;
    layers: Layer(dyn Layer) = "layer", bhs_layers::ALL;
}

/// What `bhs plugins` shows of a plugin.
#[derive(Clone, Debug, PartialEq)]
pub struct PluginInfo {
    /// Its kind, one of [`Registry::KINDS`].
    pub kind: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub summary: &'static str,
    /// Its parameters, in the order in which its constructor asks for them.
    pub params: Vec<ParamInfo>,
    /// Of a layer: what its numbers are.
    pub format: Option<LayerFormat>,
    /// Of what makes spectra: the names by which scenes ask for them.
    pub names: Vec<&'static str>,
}

impl Registry {
    /// The plugin of a kind with the given name, or the other name that it has.
    pub fn find<T: Kind + ?Sized>(&self, name: &str) -> Option<Plugin<T>> {
        let named = |name: &str| T::list(self).iter().find(|p| p.name == name).copied();
        named(name).or_else(|| named(full_name(T::WORD, name)))
    }

    /// The names of all plugins of a kind.
    pub fn names<T: Kind + ?Sized>(&self) -> Vec<&'static str> {
        T::list(self).iter().map(|p| p.name).collect()
    }

    /// The maker of spectra.
    pub fn spectra(&self) -> &dyn SpectrumSource {
        self
    }

    /// Makes the plugin that `entity` names. All that is wrong goes to `found`; a plugin may come back all the same.
    pub fn create<T: Kind + ?Sized>(&self, entity: &Entity, context: Context, found: &mut Vec<Diagnostic>) -> Option<Box<T>> {
        self.create_with(entity, context, found, |_| None::<()>).0
    }

    /// The same, and what the directive itself reads of the parameters: see `directive_params`.
    pub fn create_with<T: Kind + ?Sized, D>(
        &self,
        entity: &Entity,
        context: Context,
        found: &mut Vec<Diagnostic>,
        read: impl FnOnce(&Params) -> Option<D>,
    ) -> (Option<Box<T>>, Option<D>) {
        let Some(plugin) = self.find::<T>(&entity.name.value) else {
            found.push(self.unknown::<T>(&entity.name));
            return (None, None);
        };
        let params = Params::new(entity.name.clone(), &entity.params, context).with_defaults(&entity.defaults);
        let made = (plugin.build)(&params);
        let of_directive = read(&params);
        let (mut faults, asked) = params.finish();
        asked.iter().for_each(|a| entity.defaults.take(a.name));
        advice::advise(&mut faults, entity, &asked);
        // What has been left out because it is at fault is not missing.
        faults.retain(|d| !(entity.faulty && d.code == "missing-parameter"));
        if made.is_none() && faults.is_empty() && !entity.faulty {
            faults.push(
                Diagnostic::error("plugin-failed", format!("{} `{}` could not be made", T::WORD, entity.name.value))
                    .at(entity.name.span, "and does not say why")
                    .help("this is a fault of the plugin"),
            );
        }
        found.extend(faults);
        (made, of_directive)
    }

    /// Makes the film that `entity` names, and the layers that its directive asks for.
    pub fn create_film(
        &self,
        entity: &Entity,
        context: Context,
        found: &mut Vec<Diagnostic>,
    ) -> (Option<Box<dyn Film>>, Vec<NamedLayer>) {
        let (film, layers) = self.create_with(entity, context, found, |p| Some(read_layers(p, &self.layers)));
        (film, layers.unwrap_or_default())
    }

    /// The error that a kind has no plugin of this name.
    pub fn unknown<T: Kind + ?Sized>(&self, name: &Spanned<String>) -> Diagnostic {
        let names = self.names::<T>();
        let others = bhs_integrators::OTHER_NAMES.iter().filter(|_| T::WORD == "integrator").map(|(other, _)| *other);
        let help = match did_you_mean(&name.value, names.iter().copied().chain(others)) {
            _ if let Some(advice) = glossary::plugin(T::WORD, &name.value) => advice,
            Some(near) => format!("did you mean `{near}`?"),
            None if names.is_empty() => format!("there is no {}", T::WORD),
            None => format!("there is {}", names.join(", ")),
        };
        Diagnostic::error("unknown-plugin", format!("unknown {} `{}`", T::WORD, shorten(&name.value)))
            .at(name.span, "")
            .help(help)
    }

    /// The parameters that the plugin of a kind takes; empty if there is no such plugin.
    pub fn parameters<T: Kind + ?Sized>(&self, name: &str) -> Vec<ParamInfo> {
        self.find::<T>(name).map(|p| self.describe_one(&p).params).unwrap_or_default()
    }

    /// Runs a constructor without parameters, for its table.
    fn describe_one<T: Kind + ?Sized>(&self, plugin: &Plugin<T>) -> PluginInfo {
        let context = Context { resolution: [64, 64], ..bare_context(&NoFiles, self.spectra()) };
        let none = || Params::new(Spanned::new(plugin.name.to_owned(), Span::default()), &[], context);
        let params = none();
        // Only what it asks for counts here, not what it makes.
        drop((plugin.build)(&params));
        self.directive_params(T::WORD, &params);
        let (_, asked) = params.finish();
        let layer = if T::WORD == <dyn Layer>::WORD { self.find::<dyn Layer>(plugin.name) } else { None };
        let maker = if T::WORD == <dyn SpectrumMaker>::WORD { self.find::<dyn SpectrumMaker>(plugin.name) } else { None };
        PluginInfo {
            kind: T::WORD,
            name: plugin.name,
            summary: plugin.summary,
            params: asked,
            format: layer.and_then(|layer| (layer.build)(&none())).map(|layer| layer.format()),
            names: maker.and_then(|maker| (maker.build)(&none())).map(|maker| maker.names()).unwrap_or_default(),
        }
    }

    /// Asks for the parameters that the directives of a kind take besides those of its plugins.
    fn directive_params(&self, kind: &str, params: &Params) {
        match kind {
            "spacetime" => drop(Conventions::read(params)),
            "camera" => drop(self.viewpoint(params)),
            "shape" => drop(self.motion(params)),
            "film" => drop(read_layers(params, &self.layers)),
            "material" => drop(Bumps::read(params)),
            _ => {}
        }
    }

    /// How what a directive makes moves, as its parameters state it; `None`: at rest, or something is wrong, which is reported.
    pub fn motion(&self, params: &Params) -> Option<Box<dyn Motion>> {
        read_motion(params, &|name| self.find(&name.value).ok_or_else(|| Box::new(self.unknown::<dyn Motion>(name))))
    }

    /// What the parameters of a camera's directive state of where it looks from; `None` if something is wrong with them.
    pub fn viewpoint(&self, params: &Params) -> Option<Viewpoint> {
        Viewpoint::read(params, &|name| self.find(&name.value).ok_or_else(|| Box::new(self.unknown::<dyn Motion>(name))))
    }
}

impl SpectrumSource for Registry {
    fn build(&self, param: &Param, role: SpectrumRole, context: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        bhs_spectra::build_with(&self.spectra, param, role, context).map_err(|mut found| {
            for d in found.iter_mut().filter(|d| d.code == "unknown-spectrum") {
                let names = if let Values::Strings(texts) = &param.values { texts.as_slice() } else { &[] };
                let advice = names.iter().find_map(|name| glossary::plugin("spectrum", &name.value));
                d.help = advice.or(d.help.take());
            }
            found
        })
    }
}

/// The name of the plugin of the kind `kind` that is also called `name`; else `name` itself.
pub fn full_name<'a>(kind: &str, name: &'a str) -> &'a str {
    let known = bhs_integrators::OTHER_NAMES.iter().find(|(other, _)| kind == "integrator" && *other == name);
    known.map_or(name, |(_, plugin)| *plugin)
}

/// A context in which nothing of the scene is known yet.
pub fn bare_context<'a>(files: &'a dyn Files, spectra: &'a dyn SpectrumSource) -> Context<'a> {
    Context {
        files,
        spectra,
        named: &Nameless,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [0, 0],
        lambda_range: [360.0, 830.0],
        seed: 0,
    }
}

/// Files of a constructor that may read none.
pub(crate) struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Err("no file is read here".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::camera::CameraRay;
    use glam::{DVec2, DVec3, Vec2};

    struct Nowhere;
    impl Camera for Nowhere {
        fn ray(&self, _: DVec2, _: Vec2) -> CameraRay {
            CameraRay { origin: DVec3::ZERO, direction: DVec3::Z }
        }
        fn position(&self) -> DVec3 {
            DVec3::ZERO
        }
        fn pixel_width(&self, distance: f64) -> f64 {
            1e-3 * distance
        }
        fn rebase(&mut self, _: DVec3) {}
    }

    fn build(p: &Params) -> Option<Box<dyn Camera>> {
        p.get("depth", 2.0, "m", "how deep");
        Some(Box::new(Nowhere))
    }

    #[test]
    fn a_plugin_from_outside_is_found_described_and_made() {
        let registry = Registry::builtin().with(Plugin::<dyn Camera> { name: "nowhere", summary: "looks at nothing", build });
        let info = registry.describe().into_iter().find(|p| p.name == "nowhere").unwrap();
        assert_eq!((info.kind, info.params[0].name, info.params[0].default.as_str()), ("camera", "depth", "2"));

        let name = Spanned::new("nowhere".to_owned(), Span::default());
        let mut entity = Entity {
            name,
            params: Vec::new(),
            defaults: Default::default(),
            span: Span::default(),
            keyword: Span::default(),
            faulty: false,
            world_from_object: Default::default(),
            side: bhs_core::spacetime::Side::Near,
        };
        let mut found = Vec::new();
        let context = bare_context(&NoFiles, registry.spectra());
        assert!(registry.create::<dyn Camera>(&entity, context, &mut found).is_some());
        assert!(found.is_empty());
        entity.name.value = "nowhare".into();
        assert!(registry.create::<dyn Camera>(&entity, context, &mut found).is_none());
        assert_eq!(found[0].help.as_deref(), Some("did you mean `nowhere`?"));
    }

    #[test]
    fn other_names_are_those_of_plugins() {
        let registry = Registry::builtin();
        for (other, name) in bhs_integrators::OTHER_NAMES {
            assert_eq!(registry.find::<dyn IntegratorBuilder>(other).map(|p| p.name), Some(*name));
            assert!(registry.find::<dyn LightTransport>(other).is_none());
        }
    }

    #[test]
    fn all_kinds_have_plugins_and_all_plugins_a_summary() {
        let all = Registry::builtin().describe();
        for kind in Registry::KINDS {
            assert!(all.iter().any(|p| p.kind == *kind), "{kind}");
        }
        assert!(all.iter().all(|p| !p.summary.is_empty()));
    }
}
