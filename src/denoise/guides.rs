//! Guides are filtered where they have noise.
//!
//! What is seen in glass and by few samples of a textured or blurred thing is noisy, and filtered by itself first. Elsewhere the filter only blurs: the image of
//! a room in the light that is bent around a hole is a few pixels wide, and its edges are in the guides. Noise is everywhere around, edges are not:
//! where a quarter of the neighbours are hardly changed by the filter, there is none. Measured: docs/performance.md, "Denoising".

/// Half the width of a pixel's neighbourhood.
const RADIUS: usize = 3;

/// Change up to which the filter found nothing to do; from twice that on, what it made is taken.
const CHANGE: f32 = 0.02;

/// Puts `raw` in place of what the filter made of it where there was no noise; both of three channels.
pub(super) fn keep_what_has_no_noise(filtered: &mut [f32], raw: &[f32], [width, height]: [usize; 2]) {
    let change = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0f32, f32::max);
    let changes: Vec<f32> = filtered.as_chunks::<3>().0.iter().zip(raw.as_chunks::<3>().0).map(change).collect();
    let mut around = Vec::with_capacity((2 * RADIUS + 1) * (2 * RADIUS + 1));
    for (i, (own, raw)) in filtered.as_chunks_mut::<3>().0.iter_mut().zip(raw.as_chunks::<3>().0).enumerate() {
        let (x, y) = (i % width, i / width);
        let columns = x.saturating_sub(RADIUS)..(x + RADIUS + 1).min(width);
        around.clear();
        for row in y.saturating_sub(RADIUS)..(y + RADIUS + 1).min(height) {
            around.extend_from_slice(&changes[row * width..][columns.clone()]);
        }
        let quarter = around.len() / 4;
        let (_, change, _) = around.select_nth_unstable_by(quarter, f32::total_cmp);
        let share = (*change / CHANGE - 1.0).clamp(0.0, 1.0);
        (0..3).for_each(|c| own[c] = raw[c] + share * (own[c] - raw[c]));
    }
}

#[cfg(test)]
mod tests {
    use super::keep_what_has_no_noise;

    #[test]
    fn edges_stay_and_noise_goes() {
        let size = [16, 16];
        // An edge in the left half, which the filter has blurred; noise in the right half, which it has taken away.
        let at = |i: usize| (i / 3 % 16, i / 3 / 16);
        let noise = |i: usize| if (i / 3).is_multiple_of(2) { 0.3 } else { 0.7 };
        let raw: Vec<f32> = (0..16 * 16 * 3).map(|i| if at(i).0 >= 8 { noise(i) } else { f32::from(at(i).1 >= 8) }).collect();
        let blurred = |y: usize| [0.0, 0.2, 0.8, 1.0][(y + 1).saturating_sub(6).min(3)];
        let filtered: Vec<f32> = (0..raw.len()).map(|i| if at(i).0 >= 8 { 0.5 } else { blurred(at(i).1) }).collect();
        let mut kept = filtered.clone();
        keep_what_has_no_noise(&mut kept, &raw, size);
        for (i, kept) in kept.iter().enumerate() {
            match at(i).0 {
                0..5 => assert_eq!(*kept, raw[i], "{:?}", at(i)),
                12.. => assert!((kept - filtered[i]).abs() < 1e-6, "{:?}", at(i)),
                _ => {}
            }
        }
        // Neighbourhoods of single pixels.
        let mut one = vec![0.5; 3];
        keep_what_has_no_noise(&mut one, &[0.51; 3], [1, 1]);
        assert_eq!(one, [0.51; 3]);
    }
}
