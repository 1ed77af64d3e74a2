//! Lights that shine from a point or from far away (KHR_lights_punctual).

use crate::lang::ast::Directive;
use crate::lang::params::{named, set, set_floats, set_rgb};
use bhs_core::diagnostics::Span;
use bhs_core::value::{ParamType, Values};
use bhs_models::gltf::khr_lights_punctual::{Kind, Light};

/// The brightest that numbers of single precision hold with room for sums.
const BRIGHTEST: f64 = 1e30;

/// The directive of a light that looks along -z of the current transform. One candela is an intensity of 1, one lux an irradiance of 1.
pub(super) fn directive(light: &Light, at: Span) -> Directive {
    let intensity = f64::from(light.intensity());
    let colour = light.color().map(|c| (f64::from(c) * intensity).clamp(0.0, BRIGHTEST));
    let aim = |d: &mut Directive| {
        let values = Values::Numbers { values: vec![0.0, 0.0, -1.0], whole: false };
        set(d, ParamType::Point3, "to", values);
    };
    match light.kind() {
        Kind::Directional => {
            let mut d = named("LightSource", "distant", at);
            set_rgb(&mut d, "L", colour);
            aim(&mut d);
            d
        }
        Kind::Point => {
            let mut d = named("LightSource", "point", at);
            set_rgb(&mut d, "I", colour);
            d
        }
        Kind::Spot { inner_cone_angle, outer_cone_angle } => {
            let mut d = named("LightSource", "spot", at);
            set_rgb(&mut d, "I", colour);
            aim(&mut d);
            let outer = f64::from(outer_cone_angle).to_degrees().clamp(0.001, 180.0);
            let inner = f64::from(inner_cone_angle).to_degrees().clamp(0.0, outer);
            set_floats(&mut d, "coneangle", &[outer]);
            set_floats(&mut d, "conedeltaangle", &[outer - inner]);
            d
        }
    }
}
