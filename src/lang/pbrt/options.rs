//! The options of a file, once all of them are known: the last of each kind counts, with pbrt-v4's defaults.

use crate::lang::ast::Directive;
use crate::lang::params::{
    boolean, drop_all, find, float, name, named, number, set, set_floats, set_strings, set_text, string, take, take_float,
};
use crate::lang::pbrt::Translator;
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::value::{Param, ParamType, Values};

/// The light transports of pbrt-v4 that are other ones here, and what to know of that.
const TRANSPORTS: &[(&str, &str)] = &[
    ("ambientocclusion", "it shows light, not how much of the sky is open"),
    ("ao", "it shows light, not how much of the sky is open"),
    ("bdpt", "light that is hard to reach from the camera, as caustics are, is noisier"),
    ("function", "it renders the scene"),
    ("lightpath", "the mean is the same"),
    ("mlt", "the mean is the same, light that is hard to find is noisier"),
    ("randomwalk", "lights are not sampled, as there"),
    ("simplepath", "the mean is the same"),
    ("simplevolpath", "the mean is the same; media are left out"),
    ("sppm", "caustics are noisier, and not blurred"),
    ("volpath", "media are left out"),
];

/// The integrators of light rays, which a file of pbrt's may name too.
const OURS: &[&str] = &[
    "adaptive",
    "exact",
    "general",
    "micro-steps",
    "rk4",
    "schwarzschild-adaptive",
    "schwarzschild-exact",
    "schwarzschild-rk4",
    "straight",
];

impl Translator {
    /// The options as they are to be run; `at` is the place of `WorldBegin`.
    pub(super) fn take_options(&mut self, at: Span) -> Vec<Directive> {
        let mut options = std::mem::take(&mut self.options);
        let is_rays = |d: &Directive| d.keyword.value == "Integrator" && OURS.contains(&name(d));
        // Of each kind the last one; ours and theirs of the word `Integrator` are two.
        let kind = |d: &Directive| match d.keyword.value.as_str() {
            "Camera" | "Film" | "Sampler" | "PixelFilter" | "LightTransport" => Some((d.keyword.value.clone(), false)),
            "Integrator" => Some((d.keyword.value.clone(), is_rays(d))),
            _ => None,
        };
        // Cameras with names of their own are several pictures.
        let label = |d: &Directive| string(d, "name").filter(|_| d.keyword.value == "Camera").map(|s| s.value.clone());
        let keys: Vec<_> = options.iter().map(|d| kind(d).map(|k| (k, label(d)))).collect();
        let mut index = 0;
        options.retain(|_| {
            let key = &keys[index];
            index += 1;
            key.is_none() || !keys[index..].contains(key)
        });
        let exposure = self.exposure_time(&mut options);
        let mut seed = None;
        let mut out = Vec::new();
        for mut d in options {
            match d.keyword.value.as_str() {
                "Camera" => self.camera(&mut d),
                "Film" => self.film(&mut d, exposure),
                "Sampler" => seed = self.sampler(&mut d).or(seed),
                "Option" => self.option(&mut d),
                "Integrator" if !OURS.contains(&name(&d)) => self.integrator(&mut d),
                _ => {}
            }
            let is_empty_option = d.keyword.value == "Option" && d.params.is_empty();
            if d.keyword.value == "LightTransport" {
                out.retain(|o: &Directive| o.keyword.value != "LightTransport");
            }
            if !is_empty_option {
                out.push(d);
            }
        }
        let has = |out: &[Directive], word: &str| out.iter().any(|d| d.keyword.value == word);
        if !has(&out, "PixelFilter") {
            out.push(named("PixelFilter", "gaussian", at));
        }
        if !has(&out, "Film") && exposure != 1.0 {
            let mut film = named("Film", "rgb", at);
            set_floats(&mut film, "imagingratio", &[exposure]);
            out.push(film);
        }
        if let Some(seed) = seed {
            let mut option = super::params::directive("Option", at);
            option.params.push(seed);
            out.push(option);
        }
        out
    }

    /// How long the shutter of the camera is open (s).
    fn exposure_time(&mut self, options: &mut [Directive]) -> f64 {
        let mut time = 1.0;
        for camera in options.iter_mut().filter(|d| d.keyword.value == "Camera") {
            let at = find(camera, "shutterclose").or(find(camera, "shutteropen")).map_or(camera.keyword.span, |p| p.span);
            let open = take_float(camera, "shutteropen").unwrap_or(0.0);
            let close = take_float(camera, "shutterclose").unwrap_or(1.0);
            time = close - open;
            if time <= 0.0 {
                let message = "the shutter never opens: `shutterclose` is not after `shutteropen`";
                self.notes.error(Diagnostic::error("bad-value", message).at(at, "").help("the picture would be black"));
                time = 1.0;
            }
        }
        time
    }

    fn camera(&mut self, d: &mut Directive) {
        let (word, at) = (name(d).to_owned(), d.keyword.span);
        if word == "realistic" {
            let help = "there are no lenses: the picture has another angle of view, and no vignette";
            self.notes.mapped("the camera", &word, "`perspective`", at, help);
            set_text(d, 0, "perspective");
            drop_all(d, &["lensfile", "aperturediameter", "focusdistance", "aperture"]);
        }
        if word == "spherical" && drop_all(d, &["lensradius", "focaldistance", "frameaspectratio", "screenwindow"]) {
            self.notes.ignored("lensradius", at, "a `spherical` camera has no lens");
        }
    }

    fn film(&mut self, d: &mut Directive, exposure: f64) {
        let (word, at) = (name(d).to_owned(), d.keyword.span);
        match word.as_str() {
            "gbuffer" => {
                let layers = ["position", "normal", "shadingnormal", "depth", "albedo", "variance"];
                let help = "its layers are in world space";
                self.notes.mapped("the film", &word, "`rgb` with `layers`", at, help);
                set_text(d, 0, "rgb");
                set_strings(d, ParamType::String, "layers", &layers);
            }
            "image" => {
                self.notes.mapped("the film", &word, "`rgb`", at, "the name is that of pbrt-v3");
                set_text(d, 0, "rgb");
            }
            _ => {}
        }
        drop_all(d, &["diagonal", "savefp16", "coordinatesystem"]);
        if let Some(sensor) = string(d, "sensor").cloned() {
            if sensor.value != "cie1931" {
                let help = "it sees as the standard observer; colours differ a little";
                self.notes.mapped("the sensor", &sensor.value, "`cie1931`", sensor.span, help);
            }
            take(d, "sensor");
        }
        let ratio = exposure * take_float(d, "iso").unwrap_or(100.0) / 100.0;
        if ratio != 1.0 {
            set_floats(d, "imagingratio", &[ratio]);
        }
        if float(d, "whitebalance") == Some(0.0) {
            take(d, "whitebalance");
        }
        if let Some(bounds) = find(d, "pixelbounds").cloned()
            && let Values::Numbers { values, .. } = &bounds.values
            && let &[x0, x1, y0, y1] = values.as_slice()
        {
            let [x, y] = [float(d, "xresolution").unwrap_or(1280.0), float(d, "yresolution").unwrap_or(720.0)];
            take(d, "pixelbounds");
            // Half a pixel before the first one and behind the last one, so that rounding chooses none else.
            let window = [x0 / x, x1 / x, y0 / y, y1 / y].map(|f| f.clamp(0.0, 1.0));
            set_floats(d, "cropwindow", &window);
        }
        if let Some(file) = string(d, "filename").cloned()
            && !file.value.is_empty()
            && !file.value.to_ascii_lowercase().ends_with(".exr")
        {
            let path = std::path::Path::new(&file.value).with_extension("exr");
            let message = format!("the picture `{}` is written as OpenEXR", bhs_core::diagnostics::shorten(&file.value));
            self.notes.warn(&message, file.span, "", "a PNG stands beside it");
            set_strings(d, ParamType::String, "filename", &[&path.to_string_lossy()]);
        }
    }

    /// The seed that a sampler states, which is an option here.
    fn sampler(&mut self, d: &mut Directive) -> Option<Param> {
        let word = name(d).to_owned();
        if matches!(word.as_str(), "halton" | "paddedsobol" | "pmj02bn" | "zsobol") {
            set_text(d, 0, "sobol");
        }
        if word == "independent" && find(d, "pixelsamples").is_none() {
            set(d, ParamType::Integer, "pixelsamples", Values::Numbers { values: vec![4.0], whole: true });
        }
        drop_all(d, &["randomization"]);
        let seed = take(d, "seed")?;
        // pbrt's may be negative.
        number(&seed).is_some_and(|s| s >= 0.0).then_some(seed)
    }

    fn option(&mut self, d: &mut Directive) {
        const OWN: &[&str] = &["intersector", "seed"];
        for param in d.params.iter().filter(|p| !OWN.contains(&p.name.value.as_str())) {
            self.notes.ignored(&format!("Option {}", param.name.value), param.name.span, "it has no counterpart");
        }
        d.params.retain(|p| OWN.contains(&p.name.value.as_str()));
    }

    fn integrator(&mut self, d: &mut Directive) {
        let (word, at) = (name(d).to_owned(), d.keyword.span);
        let known = TRANSPORTS.iter().find(|(theirs, _)| *theirs == word);
        if word != "path" && word != "hemisphere" && word != "normals" && known.is_none() {
            return;
        }
        "LightTransport".clone_into(&mut d.keyword.value);
        if let Some((_, about)) = known {
            self.notes.mapped("the integrator", &word, "the light transport `path`", at, about);
            set_text(d, 0, "path");
        }
        let without_lights = word == "randomwalk" || boolean(d, "samplelights") == Some(false);
        let depth = take(d, "maxdepth");
        if word == "path" || known.is_some() {
            if boolean(d, "regularize") == Some(true) {
                self.notes.ignored("regularize", at, "light that mirrors throw is sharp, and noisy");
            }
            let own = ["rrdepth", "lightsampling", "guiding"];
            d.params.retain(|p| own.contains(&p.name.value.as_str()));
        }
        d.params.extend(depth);
        if without_lights {
            set(d, ParamType::Bool, "lightsampling", Values::Bools(vec![false]));
        }
    }
}
