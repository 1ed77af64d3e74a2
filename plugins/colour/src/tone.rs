//! Tone curves: how light without limit becomes a colour that a screen shows.

use crate::gamut::into_gamut;
use crate::matrix::{inverse, product, times, xyz_from_primaries};
use crate::srgb::{SRGB_FROM_XYZ, XYZ_FROM_SRGB};
use bhs_elementary::Elementary;

/// How linear light becomes a linear colour whose parts lie between 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Everything above 1 is 1.
    #[default]
    Clip,
    /// `x (1 + x/16) / (1 + x)` for each of red, green and blue: white at 4 (Reinhard et al. 2002, eq. 4).
    Reinhard,
    /// Narkowicz' 2016 fit of the ACES filmic curve, for each of red, green and blue, which shows 0.18 as about 0.18.
    Aces,
    /// Sobotka's AgX: colours are moved towards grey, put through a curve over 16.5 stops, and moved back by less, so that bright colours become
    /// white as on film.
    Agx,
}

impl ToneCurve {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Clip, Self::Reinhard, Self::Aces, Self::Agx];

    /// What scenes and the command line call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clip => "clip",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// The one called `name`.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|curve| curve.name() == name)
    }

    /// The linear sRGB colour, each part from 0 to 1, that shows the linear sRGB colour `rgb`. What is outside of sRGB's gamut loses as much of its
    /// colourfulness as it has to ([`into_gamut`]); greys stay grey.
    pub fn apply(self, rgb: [f32; 3]) -> [f32; 3] {
        let numbers = rgb.map(|x| if x.is_nan() { 0.0 } else { f64::from(x.clamp(f32::MIN, f32::MAX)) });
        if self == Self::Agx {
            return into_gamut(agx(numbers), 1.0).map(|x| x.clamp(0.0, 1.0) as f32);
        }
        // As white as can be long before the end, where the curves would become 0/0; but only once the hue, which is in the ratios, has been kept.
        let positive = into_gamut(numbers, f64::INFINITY).map(|x| x.clamp(0.0, 1e6) as f32);
        positive.map(|x| match self {
            Self::Clip | Self::Agx => x.min(1.0),
            Self::Reinhard => (x * (1.0 + x / 16.0) / (1.0 + x)).min(1.0),
            Self::Aces => {
                let x = 0.6 * x;
                ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
            }
        })
    }
}

/// Chromaticities of the primaries of ITU-R BT.2020, in which AgX is computed.
const REC2020_PRIMARIES: [[f64; 2]; 3] = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]];

const XYZ_FROM_REC2020: [[f64; 3]; 3] = xyz_from_primaries(REC2020_PRIMARIES);
const REC2020_FROM_SRGB: [[f64; 3]; 3] = product(inverse(XYZ_FROM_REC2020), XYZ_FROM_SRGB);
const SRGB_FROM_REC2020: [[f64; 3]; 3] = product(SRGB_FROM_XYZ, XYZ_FROM_REC2020);

/// What moves colours towards grey before the curve, and the inverse of what moves them back behind it (Eary Chow's AgX for Blender 4, as three.js r160 and
/// Filament have it); the rows add up to 1.
const INSET: [[f64; 3]; 3] = [
    [0.856_627_153_315_983, 0.095_121_240_538_158_8, 0.048_251_606_145_858_3],
    [0.137_318_972_929_847, 0.761_241_990_602_591, 0.101_439_036_467_562],
    [0.111_898_212_999_95, 0.076_799_418_603_190_3, 0.811_302_368_396_859],
];
const OUTSET_INVERSE: [[f64; 3]; 3] = [
    [0.899_796_955_911_611, 0.087_199_619_202_835_1, 0.013_003_424_885_555],
    [0.111_420_988_957_48, 0.875_575_586_156_966, 0.013_003_424_885_554_8],
    [0.111_420_988_957_48, 0.087_199_619_202_834_9, 0.801_379_391_839_686],
];
const OUTSET: [[f64; 3]; 3] = inverse(OUTSET_INVERSE);

/// Stops that the curve begins and ends with, of light of 1: 10 below and 6.5 above 0.18.
const STOPS: [f64; 2] = [-12.473_931_188_332_413, 4.026_068_811_667_588];

/// The curve of AgX of Sobotka's configuration in closed form: 0.18 (10 of the 16.5 stops) is 0.5, where the slope is 2; the ends are 0 and 1, with the
/// powers 3 (toe) and 3.25 (shoulder) of a hyperbola (Sobotka and Smith 2022; the form is that of github.com/bWFuanVzYWth/AgX).
fn sigmoid(x: f64) -> f64 {
    const PIVOT: f64 = 10.0 / 16.5;
    let (power, width) = if x < PIVOT { (3.0, PIVOT) } else { (3.25, 1.0 - PIVOT) };
    // So that the curve is 1/2 away from the middle at its end.
    let a = ((4.0 * width).power(power) - 1.0) / width.power(power);
    let off = x - PIVOT;
    0.5 + 2.0 * off * (1.0 + a * off.abs().power(power)).power(-1.0 / power)
}

/// AgX of a linear sRGB colour, in linear sRGB; it may lie a little outside of the gamut.
fn agx(rgb: [f64; 3]) -> [f64; 3] {
    let inset = times(INSET, times(REC2020_FROM_SRGB, rgb));
    let curved = inset.map(|x| sigmoid(((x.max(1e-10).logarithm2() - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(0.0, 1.0)));
    // The curve is for screens of gamma 2.2.
    times(SRGB_FROM_REC2020, times(OUTSET, curved).map(|x| x.max(0.0).power(2.2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_there_and_back() {
        assert!(ToneCurve::ALL.into_iter().all(|curve| ToneCurve::find(curve.name()) == Some(curve)));
        assert_eq!(ToneCurve::find("AGX"), None);
    }

    #[test]
    fn greys_stay_grey_and_grow_from_black_to_white() {
        for curve in ToneCurve::ALL {
            let mut last = -1.0;
            for i in 0..400 {
                let x = 2f32.powf(0.1 * i as f32 - 20.0);
                let [r, g, b] = curve.apply([x; 3]);
                assert!(
                    (r - g).abs() < 1e-6 && (g - b).abs() < 1e-6 && g >= last - 1e-6 && (0.0..=1.0).contains(&g),
                    "{curve:?} {x}: {r} {g} {b}"
                );
                last = g;
            }
            assert!(last > 0.99 && curve.apply([0.0; 3]) == [0.0; 3], "{curve:?} {last}");
            for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX] {
                let shown = curve.apply([odd, 0.5, odd]);
                assert!(shown.iter().all(|x| (0.0..=1.0).contains(x)), "{curve:?} {odd}: {shown:?}");
            }
        }
    }

    #[test]
    fn clip_leaves_what_a_screen_can_show() {
        for rgb in [[0.2, 0.7, 0.01], [1.0, 0.0, 0.0], [0.5, 0.5, 0.5]] {
            assert_eq!(ToneCurve::Clip.apply(rgb), rgb);
        }
        assert_eq!(ToneCurve::Clip.apply([3.0, 0.5, 2.0]), [1.0, 0.5, 1.0]);
    }

    /// The polynomial with which three.js (r160, `agxDefaultContrastApprox`) and Filament approach the curve, to a mean square of 3.7e-6.
    #[test]
    fn the_curve_is_that_of_other_programs() {
        let mut square = 0.0;
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let approx =
                [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5].into_iter().rev().fold(0.0, |sum, c| sum * x + c);
            square += (sigmoid(x) - approx).powi(2) / 101.0;
        }
        assert!(square < 1e-5, "{square}");
        assert!(sigmoid(0.0).abs() < 1e-12 && (sigmoid(1.0) - 1.0).abs() < 1e-12 && (sigmoid(10.0 / 16.5) - 0.5).abs() < 1e-12);
    }

    /// The whole of three.js's function, with its rounded matrices.
    #[test]
    fn colours_are_those_of_three_js() {
        let to = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0113], [0.0164, 0.0880, 0.8956]];
        let back = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        let outset = [
            [1.127_100_581_814_436_8, -0.110_606_643_096_603_23, -0.016_493_938_717_834_573],
            [-0.141_329_763_498_438_3, 1.157_823_702_216_272, -0.016_493_938_717_834_257],
            [-0.141_329_763_498_438_26, -0.110_606_643_096_602_94, 1.251_936_406_595_040_5],
        ];
        for rgb in [[0.18, 0.18, 0.18], [1.0, 0.2, 0.05], [0.02, 0.1, 0.6], [4.0, 3.0, 0.5], [0.9, 0.9, 0.2]] {
            let x = times(INSET, times(to, rgb)).map(|x: f64| (x.max(1e-10).log2() + 12.473_93) / (4.026_069 + 12.473_93));
            let curve = |x: f64| {
                [-0.002_32, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5].into_iter().rev().fold(0.0, |sum, c| sum * x + c)
            };
            let theirs = times(back, times(outset, x.map(|x| curve(x.clamp(0.0, 1.0)))).map(|x| x.max(0.0).powf(2.2)));
            let ours = agx(rgb);
            assert!(ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() < 0.01), "{rgb:?}: {ours:?} {theirs:?}");
        }
    }

    /// Lamps of one wavelength: the sodium line, lasers. Hue and lightness stay, and no part is cut off by itself.
    #[test]
    fn light_of_one_wavelength_keeps_its_hue() {
        for (bar, hue) in [
            // CIE 1931 at 450, 520, 589, 650 nm.
            ([0.3362, 0.038, 1.772_11], "blue"),
            ([0.063_27, 0.71, 0.078_25], "green"),
            ([1.010_42, 0.771_8, 0.0011], "orange"),
            ([0.2835, 0.107, 0.0], "red"),
        ] {
            let rgb = crate::srgb_from_xyz(bar);
            assert!(rgb.iter().any(|x| *x < 0.0), "{hue} is in the gamut: {rgb:?}");
            let scale = 0.9 / rgb.iter().fold(0.0f64, |a, b| a.max(*b));
            for curve in ToneCurve::ALL {
                let [r, g, b] = curve.apply(rgb.map(|x| (x * scale) as f32));
                let is = match hue {
                    "blue" => b > 2.0 * r.max(g),
                    "green" => g > 1.5 * r.max(b),
                    "orange" => r > g && g > 1.5 * b,
                    _ => r > 2.0 * g.max(b),
                };
                assert!(is, "{curve:?} {hue}: {r} {g} {b}");
                // However bright: nothing becomes darker by more light.
                let mut last = -1.0f32;
                for stops in -20..128 {
                    let bright = f64::from(stops).exp2();
                    let shown =
                        curve.apply(rgb.map(|x| (x * scale * bright).clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32));
                    let most = shown.into_iter().fold(0.0, f32::max);
                    assert!(most >= last - 1e-3, "{curve:?} {hue} {stops}: {shown:?}, before {last}");
                    last = most;
                }
            }
        }
    }
}
