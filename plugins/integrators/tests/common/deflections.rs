//! Deflections of light around holes that spin, from infinity to infinity in the plane of the equator: spin, L/E, angle (rad), for the mass 1. By
//! quadrature with 30 digits.

/// The table.
#[allow(clippy::excessive_precision, reason = "digits as they were computed")]
pub const EQUATORIAL: [(f64, f64, f64); 13] = [
    (0.5, 7.0, 0.923699855246745622),
    (0.5, -7.0, 1.52075990056546051),
    (0.5, 100.0, 0.0410069617762458526),
    (0.9, 3.0, 6.12039098739192046),
    (0.9, -7.0, 2.58883036651455383),
    (0.9, 5.0, 1.38979883089849016),
    (0.9, 10.0, 0.504632984000672382),
    (0.9, -10.0, 0.720503613953961283),
    (0.9, -100.0, 0.0416164204468715829),
    (0.998, 3.0, 3.88058845050832601),
    (0.998, -7.0, 5.52422648362972675),
    (0.998, 10.0, 0.496960188817243217),
    (0.998, -10.0, 0.739104522448639177),
];
