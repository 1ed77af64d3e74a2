//! Exposure and white balance that a picture asks for by itself.

use crate::image::Picture;
use bhs_colour::luminance;
use bhs_elementary::Elementary;

/// Luminance of middle grey.
const GREY: f64 = 0.18;
/// Shares of the lit pixels, by their luminance, between which the mean is taken; and the one that is to be white at least.
const DARK: f64 = 0.05;
const BRIGHT: f64 = 0.95;
/// The bright pixels are to be at most so many times as bright as white: a lamp or a sky in a dark room counts for no more.
const HIGHLIGHTS: f64 = 8.0;
/// White balance changes what the eye's cones get by no more than this factor between red and blue: light of one colour stays a colour.
const MOST_COLOURED: f64 = 6.0;

/// Red, green and blue of the pixels that give light.
fn lit(picture: &Picture) -> impl Iterator<Item = ([f64; 3], f64)> {
    let pixels = picture.data.chunks_exact(picture.channels.len());
    let colours = pixels.map(|p| ([p[0], p[1], p[2]].map(f64::from), luminance([p[0], p[1], p[2]])));
    colours.filter(|(_, y)| y.is_finite() && *y > 0.0)
}

/// The exposure (stops) at which the mean of the lit pixels, of their logarithms and without the darkest and brightest 5 %, is middle grey, but at which 5 % of
/// them are at least white, and these begin at no more than 8 times that. `None` without light.
pub fn stops(picture: &Picture) -> Option<f64> {
    let mut all: Vec<f32> = lit(picture).map(|(_, y)| y as f32).filter(|y| *y > 0.0 && y.is_finite()).collect();
    if all.is_empty() {
        return None;
    }
    all.sort_unstable_by(f32::total_cmp);
    let at = |share: f64| ((all.len() - 1) as f64 * share) as usize;
    let middle = &all[at(DARK)..=at(BRIGHT)];
    let mean = middle.iter().map(|y| f64::from(*y).logarithm2()).sum::<f64>() / middle.len() as f64;
    let white = -f64::from(all[at(BRIGHT)]).logarithm2();
    let stops = (GREY.logarithm2() - mean).clamp(white, white + HIGHLIGHTS.logarithm2());
    Some(stops.clamp(-64.0, 64.0))
}

/// The mean colour of the lit pixels, each counted by its colour and not by its brightness ("grey world": Buchsbaum 1980), those of less than half of the mean
/// luminance by less. `None` without light, or where it is all of one colour, which is then meant so.
pub fn white(picture: &Picture) -> Option<[f64; 3]> {
    let (sum, count) = lit(picture).fold((0.0, 0u64), |(sum, count), (_, y)| (sum + y, count + 1));
    let half = 0.5 * sum / count.max(1) as f64;
    let mut mean = [0.0; 3];
    for (rgb, y) in lit(picture) {
        let weight = (y / half).min(1.0) / y;
        mean.iter_mut().zip(rgb).for_each(|(m, v)| *m += weight * v.max(0.0));
    }
    let (least, most) = mean.iter().fold((f64::INFINITY, 0.0f64), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    (most.is_finite() && least > 0.0 && most <= MOST_COLOURED * least).then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;

    fn picture(colours: &[[f32; 3]]) -> Picture {
        let size = [colours.len(), 1];
        let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
        Picture { size, frame: Frame { offset: [0, 0], size }, channels, data: colours.as_flattened().to_vec() }
    }

    #[test]
    fn a_room_is_grey_a_sky_is_white_and_black_is_black() {
        assert_eq!(stops(&picture(&[[0.0; 3]; 9])), None);
        assert_eq!(white(&picture(&[[0.0; 3]; 9])), None);
        // An even picture is white: nothing in it is brighter.
        assert!((stops(&picture(&[[4.0; 3]; 100])).expect("lit") + 2.0).abs() < 1e-6);
        // A dark room, of which a twentieth is a lamp 1000 times as bright.
        let mut room = vec![[0.01; 3]; 100];
        room[..6].fill([10.0; 3]);
        let found = stops(&picture(&room)).expect("lit");
        assert!((f64::from(room[0][0]) * found.exp2() - HIGHLIGHTS).abs() < 1e-3, "{found}");
        // Without so much of it, the room is middle grey; black around it does not count, nor does what is no light.
        room[..6].fill([0.01; 3]);
        room[0] = [10.0; 3];
        room[1] = [0.06; 3];
        room[2..8].fill([0.06; 3]);
        room.extend([[0.0; 3], [f32::NAN; 3], [-1.0; 3]]);
        let found = stops(&picture(&room)).expect("lit");
        assert!((0.01 * found.exp2() - GREY).abs() < 0.03, "{}", 0.01 * found.exp2());
    }

    #[test]
    fn the_mean_colour_is_found_and_coloured_light_is_left() {
        let mut room = vec![[0.4, 0.3, 0.2]; 50];
        room.extend([[4.0, 3.0, 2.0]; 50]);
        let [r, g, b] = white(&picture(&room)).expect("a colour");
        assert!((r / g - 4.0 / 3.0).abs() < 1e-5 && (b / g - 2.0 / 3.0).abs() < 1e-5, "{r} {g} {b}");
        assert_eq!(white(&picture(&[[1.0, 0.1, 0.02]; 10])), None);
    }
}
