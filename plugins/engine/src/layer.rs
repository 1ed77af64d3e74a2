//! Layers: what a picture may record of every pixel besides its colour (elsewhere: AOVs, arbitrary output variables).
//!
//! A film's directive names the layers that are wanted; nothing is computed or stored for the others. A layer sees what the light transport has
//! found of the first piece of a camera's path ([`VisibleSurface`]). No ray is followed for it, but where it asks for a sum along the ray: a travel time,
//! or an angle that is not known from its end.

use crate::patch::Patch;
use crate::scene::Scene;
use crate::transport::{Behind, PathSample};
use bhs_core::Plugin;
use bhs_core::camera::Film;
use bhs_core::diagnostics::{Diagnostic, Spanned, did_you_mean};
use bhs_core::geometry::SurfaceGeometry;
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::ray::{Arrival, Ray, RayEnd, SurfaceHit};
use std::cell::OnceCell;
use std::fmt;
use std::sync::Arc;

/// A layer's value for one ray; a layer of fewer channels uses the first numbers.
pub type Value = [f64; 3];

/// The value of a layer of one channel.
#[inline]
pub fn scalar(x: f64) -> Value {
    [x, 0.0, 0.0]
}

/// What a pixel keeps of its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// The weighted mean over the camera rays that have a value.
    Mean,
    /// The same of unit vectors: the mean is brought back to length 1.
    MeanDirection,
    /// The sum over the camera rays that have a value, whatever the filter makes of them.
    Sum,
    /// The variance of the samples of the pixel's colour (red, green, blue), whatever [`Layer::value`] says: colours are known to the frame alone,
    /// after the film has made them of what the whole path brought.
    ColorVariance,
}

/// How values become the colours of a false-colour picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Display {
    /// Over the range of the picture's values, without the outliers.
    Spread,
    /// Over this range.
    Range([f64; 2]),
    /// As the reflectances (linear sRGB) that they are.
    Reflectance,
}

/// What a layer's numbers are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerFormat {
    /// Names of its channels in the EXR file: from one to three. Those of surfaces are the names of pbrt-v4's film `gbuffer`.
    pub channels: &'static [&'static str],
    /// Its unit, `scene` for scene units; empty for pure numbers.
    pub unit: &'static str,
    /// What a pixel keeps.
    pub statistic: Statistic,
    /// How it is shown.
    pub display: Display,
}

impl LayerFormat {
    /// Means, shown over their own range.
    pub const fn new(channels: &'static [&'static str], unit: &'static str) -> Self {
        Self { channels, unit, statistic: Statistic::Mean, display: Display::Spread }
    }

    /// The same, shown in another way.
    pub const fn shown(self, display: Display) -> Self {
        Self { display, ..self }
    }
}

/// Something that is recorded of the camera rays of a pixel. One implementation, one plugin.
pub trait Layer: Send + Sync {
    /// What its numbers are.
    fn format(&self) -> LayerFormat;

    /// The same layer with what it needs to know of one scene and its film, made once a render. `None`: it needs nothing, and is used as it is.
    fn for_render(&self, _scene: &Scene, _film: &dyn Film) -> Option<Box<dyn Layer>> {
        None
    }

    /// Its value for what a camera ray sees; `None` where the ray has no such value.
    fn value(&self, seen: &VisibleSurface) -> Option<Value>;
}

/// What a camera ray sees: where it ends, and who measures there. What not every layer needs is found when one asks, once.
pub struct VisibleSurface<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// The camera's ray (render space, chart).
    pub ray: Ray,
    /// Wavelength where the ray starts over that at E = 1, as the camera measures it.
    pub camera_ratio: f64,
    /// What became of the ray.
    pub end: RayEnd,
    /// What is seen behind specular surfaces, if the ray ends at one and the path went on.
    behind: Option<Behind>,
    /// What the pixel sees of the surface, where textures ask for it.
    pub patch: Option<Patch>,
    surface: OnceCell<Option<SurfaceGeometry>>,
    observer: OnceCell<Option<Observer>>,
}

impl<'s> VisibleSurface<'s> {
    /// What the camera ray of a path that has been followed sees.
    #[inline]
    pub fn new(scene: &'s Scene, path: &PathSample, camera_ratio: f64) -> Self {
        Self { behind: path.behind, patch: path.patch, ..Self::of_ray(scene, path.ray, path.first, camera_ratio) }
    }

    /// What is seen along `ray` (render space), which has come to `end`.
    #[inline]
    pub fn of_ray(scene: &'s Scene, ray: Ray, end: RayEnd, camera_ratio: f64) -> Self {
        let (surface, observer) = (OnceCell::new(), OnceCell::new());
        Self { scene, ray, camera_ratio, end, behind: None, patch: None, surface, observer }
    }

    /// The surface that is seen in mirrors and through smooth glass, and the share of its light that they leave; `None` where the ray itself meets a
    /// surface of another kind, and where nothing but the sky or a hole is seen in them.
    pub fn behind(&self) -> Option<(Self, f32)> {
        let Behind { ray, end, share } = self.behind?;
        matches!(end.arrival, Arrival::Surface(_)).then(|| (Self::of_ray(self.scene, ray, end, self.camera_ratio), share))
    }

    /// Where the ray meets a surface, if it does.
    #[inline]
    pub fn hit(&self) -> Option<&SurfaceHit> {
        match &self.end.arrival {
            Arrival::Surface(hit) => Some(hit),
            _ => None,
        }
    }

    /// Normals and texture coordinates there.
    #[inline]
    pub fn surface(&self) -> Option<&SurfaceGeometry> {
        self.surface.get_or_init(|| self.hit().map(|hit| self.scene.world.surface(hit))).as_ref()
    }

    /// Who moves with the surface there; `None` also where nothing can move so.
    #[inline]
    pub fn observer(&self) -> Option<&Observer> {
        self.observer.get_or_init(|| self.hit().and_then(|hit| self.scene.surface_observer(hit))).as_ref()
    }
}

/// A layer that a picture records.
#[derive(Clone)]
pub struct NamedLayer {
    /// The name that scenes and the command line use.
    pub name: &'static str,
    /// What its numbers are.
    pub format: LayerFormat,
    /// What finds them.
    pub layer: Arc<dyn Layer>,
}

impl fmt::Debug for NamedLayer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name)
    }
}

/// The layer called `name` among those of `known`.
///
/// # Errors
/// What to write instead.
pub fn find(name: &str, known: &[Plugin<dyn Layer>]) -> Result<Plugin<dyn Layer>, String> {
    known.iter().find(|plugin| plugin.name == name).copied().ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|plugin| plugin.name).collect();
        let all = names.join(", ");
        match did_you_mean(name, names) {
            Some(near) => format!("did you mean `{near}`? There is {all}"),
            None if all.is_empty() => "there is no layer".to_owned(),
            None => format!("there is {all}"),
        }
    })
}

/// The parameter of layers that are of what is seen in mirrors and through smooth glass: whether they are to be of the first surface instead.
pub fn read_first_surface(p: &Params) -> bool {
    p.get(
        "firstsurface",
        false,
        "",
        "whether it is that of the first surface, and not of what is seen in mirrors and through smooth glass",
    )
}

/// The layers that the directive of a film names, each once; parameters of theirs stand beside `layers`. All that is wrong is reported.
pub fn read_layers(p: &Params, known: &[Plugin<dyn Layer>]) -> Vec<NamedLayer> {
    let mut layers: Vec<NamedLayer> = Vec::new();
    for name in p.get("layers", Vec::<Spanned<String>>::new(), "", "what else is recorded, such as \"sweptangle\"") {
        if layers.iter().any(|layer| layer.name == name.value) {
            p.report(
                Diagnostic::error("duplicate-layer", format!("the layer `{}` is named twice", name.value))
                    .at(name.span, "named again here")
                    .help("remove one of the two"),
            );
            continue;
        }
        match find(&name.value, known) {
            Ok(plugin) => layers.extend(make(p, plugin, &name, &layers)),
            Err(help) => p.report(Diagnostic::error("unknown-layer", "unknown layer of the film").at(name.span, "").help(help)),
        }
    }
    layers
}

/// A layer, unless its numbers cannot be recorded beside those of `others`.
fn make(p: &Params, plugin: Plugin<dyn Layer>, name: &Spanned<String>, others: &[NamedLayer]) -> Option<NamedLayer> {
    let layer: Arc<dyn Layer> = (plugin.build)(p)?.into();
    let format = layer.format();
    let taken = format.channels.iter().find(|c| others.iter().any(|other| other.format.channels.contains(c)));
    let cause = match taken {
        _ if !(1..=3).contains(&format.channels.len()) => "it has to have from one to three channels".to_owned(),
        Some(channel) => format!("another layer has the channel `{channel}` too"),
        None => return Some(NamedLayer { name: plugin.name, format, layer }),
    };
    let message = format!("layer `{}` could not be made", name.value);
    p.report(Diagnostic::error("plugin-failed", message).at(name.span, cause).help("this is a fault of the plugin"));
    None
}
