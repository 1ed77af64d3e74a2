//! Light as the network takes it: every number one, and of about the brightness of 1.

use bhs_elementary::Elementary;

/// Whether a number is as large as files can say: more light than that.
fn is_lamp(v: f32) -> bool {
    v >= f32::MAX
}

/// Gives numbers that are none, or beyond all, the mean of their neighbours that are some, or 0: one pixel alone is noise. The places of those that are not
/// alone, or have no such neighbour: lamps as bright as can be, which are no noise and stay what they are. The picture has three channels.
pub(super) fn fill_holes(light: &mut [f32], [width, height]: [usize; 2]) -> Vec<usize> {
    let is_light = |v: f32| v.is_finite() && v.abs() < f32::MAX;
    let mut lamps = Vec::new();
    let filled: Vec<(usize, f32)> = (0..light.len())
        .filter(|i| !is_light(light[*i]))
        .map(|i| {
            let (x, y, c) = (i / 3 % width, i / 3 / width, i % 3);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let around = rows.flat_map(|y| columns.clone().map(move |x| (y * width + x) * 3 + c)).filter(|at| *at != i);
            let (mut sum, mut count, mut has_lamp) = (0.0f64, 0u32, false);
            for v in around.map(|i| light[i]) {
                has_lamp |= is_lamp(v);
                if is_light(v) {
                    sum += f64::from(v);
                    count += 1;
                }
            }
            if is_lamp(light[i]) && (has_lamp || count == 0) {
                lamps.push(i);
            }
            (i, (sum / f64::from(count.max(1))) as f32)
        })
        .collect();
    filled.into_iter().for_each(|(i, v)| light[i] = v);
    lamps
}

/// By how many stops, a whole number, light is to be brightened so that the mean of the lit pixels, of their logarithms, is about 1.
///
/// The library finds an exposure by itself, but counts what is darker than 1e-8 as black: light of whatever unit has to be above that.
pub(super) fn stops_to_one(light: &[f32]) -> i32 {
    let lit = light.as_chunks::<3>().0.iter().map(|rgb| bhs_colour::luminance(*rgb)).filter(|y| *y > 0.0);
    let (sum, count) = lit.fold((0.0, 0u64), |(sum, count), y| (sum + y.logarithm2(), count + 1));
    -(sum / count.max(1) as f64).round() as i32
}

/// Multiplies with a power of two: exact, but where the result has no normal number.
pub(super) fn brighten(light: &mut [f32], stops: i32) {
    if stops != 0 {
        let factor = f64::from(stops).exponential2();
        light.iter_mut().for_each(|v| *v = crate::image::single_precision(f64::from(*v) * factor));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_any_unit_becomes_light_of_about_one() {
        for k in [-120, -40, -1, 0, 3, 100] {
            let unit = f64::from(k).exp2() as f32;
            let before: Vec<f32> = (0..300).map(|i| if i < 30 { 0.0 } else { unit * (0.7 + 0.001 * i as f32) }).collect();
            let mut light = before.clone();
            let stops = stops_to_one(&light);
            brighten(&mut light, stops);
            assert!(stops == -k && light[30..].iter().all(|v| (0.7..1.1).contains(v)), "{k}: {stops}");
            brighten(&mut light, -stops);
            assert_eq!(light, before);
        }
        assert_eq!(stops_to_one(&[0.0; 9]), 0);
        assert_eq!(stops_to_one(&[]), 0);
    }

    #[test]
    fn holes_are_filled_and_lamps_are_found() {
        let size = [5, 4];
        let mut light = vec![2.0f32; 60];
        let at = |x: usize, y: usize| 3 * (5 * y + x);
        light[at(0, 0)] = f32::NAN;
        light[at(2, 1)] = f32::MAX;
        for (x, y) in [(3, 3), (4, 3), (4, 2), (3, 2)] {
            light[at(x, y) + 1] = f32::INFINITY;
        }
        let lamps = fill_holes(&mut light, size);
        let expected = [(3, 2), (4, 2), (3, 3), (4, 3)].map(|(x, y)| at(x, y) + 1);
        assert_eq!(lamps, expected);
        assert!([at(0, 0), at(2, 1), at(3, 2) + 1].into_iter().all(|i| light[i] == 2.0), "{light:?}");
        assert_eq!(fill_holes(&mut [f32::MAX; 12], [2, 2]), (0..12).collect::<Vec<_>>());
        assert_eq!(fill_holes(&mut [f32::MAX, f32::NAN, f32::NEG_INFINITY], [1, 1]), [0]);
    }
}
