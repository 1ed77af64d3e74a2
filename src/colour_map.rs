//! Colour maps: numbers from 0 to 1 as colours, from dark to bright (Smith, van der Walt and Firing 2015, matplotlib, CC0).

/// Ten equal steps, sRGB, linear between.
pub type ColourMap = [[u8; 3]; 10];

/// From dark blue over green to yellow.
pub const VIRIDIS: ColourMap = [
    [0x44, 0x01, 0x54],
    [0x48, 0x28, 0x78],
    [0x3e, 0x49, 0x89],
    [0x31, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6e, 0xce, 0x58],
    [0xb5, 0xde, 0x2b],
    [0xfd, 0xe7, 0x25],
];

/// From black over violet and orange to light yellow.
pub const MAGMA: ColourMap = [
    [0x00, 0x00, 0x04],
    [0x18, 0x0f, 0x3e],
    [0x45, 0x10, 0x77],
    [0x72, 0x1f, 0x81],
    [0x9f, 0x2f, 0x7f],
    [0xcd, 0x40, 0x71],
    [0xf1, 0x60, 0x5d],
    [0xfd, 0x95, 0x67],
    [0xfe, 0xc9, 0x8d],
    [0xfc, 0xfd, 0xbf],
];

/// The colour of a number; what is none is as large as can be.
pub fn colour(map: &ColourMap, v: f64) -> [u8; 3] {
    let at = if v.is_nan() { 1.0 } else { v.clamp(0.0, 1.0) } * (map.len() - 1) as f64;
    let i = (at as usize).min(map.len() - 2);
    let s = at - i as f64;
    std::array::from_fn(|c| (f64::from(map[i][c]) * (1.0 - s) + f64::from(map[i + 1][c]) * s + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_colours_whatever_they_are() {
        for map in [VIRIDIS, MAGMA] {
            let all = [0.0, -3.0, 1.0, f64::INFINITY, f64::NAN, 4.0 / 9.0].map(|v| colour(&map, v));
            assert_eq!(all, [map[0], map[0], map[9], map[9], map[9], map[4]]);
        }
        assert_eq!(colour(&MAGMA, 0.5 / 9.0), [12, 8, 33]);
    }
}
