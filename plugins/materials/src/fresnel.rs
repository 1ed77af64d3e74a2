//! Fresnel's equations: what share of unpolarised light a smooth interface reflects.

use glam::Vec3;

/// The power reflectance of an interface between two dielectrics at `cos_i` >= 0, and the cosine of the refracted direction
/// (0 where the reflection is total). `eta` is the refractive index on the far side over that on the side of `cos_i`.
///
/// Born and Wolf 1999, "Principles of Optics", section 1.5.2, eqs. (21a) and (35).
pub fn dielectric(cos_i: f32, eta: f32) -> (f32, f32) {
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t)
}

/// The power reflectance of a conductor of complex index `eta + i k`, seen from vacuum at `cos_i` >= 0.
///
/// Born and Wolf 1999, section 14.2 (eqs. 14.2.10 to 14.2.17), in real arithmetic: with `(a + i b)^2 = (eta + i k)^2 - sin^2`,
/// the complex cosine of the refracted wave times its index is `a + i b`.
pub fn conductor(cos_i: f32, eta: f32, k: f32) -> f32 {
    if eta > LARGE || k > LARGE {
        return conductor_of_large_index(cos_i.into(), eta.into(), k.into()) as f32;
    }
    let cos2 = cos_i * cos_i;
    let sin2 = (1.0 - cos2).max(0.0);
    let real = eta * eta - k * k - sin2;
    let a2_plus_b2 = (real * real + 4.0 * eta * eta * k * k).sqrt();
    // Of the two forms of a^2 (a^2 b^2 = eta^2 k^2) the one that does not cancel.
    let a2 = if real > 0.0 { 0.5 * (a2_plus_b2 + real) } else { 2.0 * (eta * k).powi(2) / (a2_plus_b2 - real) };
    // Grazing an index of exactly one: 0/0 here, nothing refracted.
    let a = if a2.is_nan() { 0.0 } else { a2.sqrt() };
    let two_a_cos = 2.0 * a * cos_i;
    let (sum, product) = (a2_plus_b2 + cos2, two_a_cos);
    let perpendicular = (sum - product) / (sum + product);
    let (sum, product) = (cos2 * a2_plus_b2 + sin2 * sin2, two_a_cos * sin2);
    if sum + product == 0.0 {
        // Grazing an index of exactly one: the limit.
        return 1.0;
    }
    let parallel = perpendicular * (sum - product) / (sum + product);
    0.5 * (parallel + perpendicular)
}

/// Fourth powers of larger indices leave single precision.
const LARGE: f32 = 1e4;

/// The same for an index that is large: sin^2 is nothing beside its square, light goes straight on inside, and `a + i b` is the index itself.
fn conductor_of_large_index(cos_i: f64, eta: f64, k: f64) -> f64 {
    let ratio = |cos: f64, one: f64| {
        let (less, more) = (eta * cos - one, eta * cos + one);
        let absorbed = k * cos * k * cos;
        (less * less + absorbed) / (more * more + absorbed)
    };
    0.5 * (ratio(cos_i, 1.0) + ratio(1.0, cos_i))
}

/// The direction that mirrors `w` at a surface with the unit normal `n`.
pub fn reflect(w: Vec3, n: Vec3) -> Vec3 {
    2.0 * w.dot(n) * n - w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_agree_where_they_meet_and_the_largest_indices_are_mirrors() {
        for cos in [0.0f32, 1e-3, 0.1, 0.5, 0.9, 1.0] {
            for (eta, k) in [(9999.0f32, 9999.0), (9999.0, 0.0), (1.5, 9999.0), (0.0, 9999.0)] {
                let large = conductor_of_large_index(cos.into(), eta.into(), k.into()) as f32;
                assert!((conductor(cos, eta, k) - large).abs() < 2e-6, "{cos} {eta} {k}: {} {large}", conductor(cos, eta, k));
            }
            for index in [1e30f32, f32::MAX] {
                for (eta, k) in [(index, index), (index, 0.0), (0.0, index), (1e-30, index), (index, 1e-30)] {
                    assert!((conductor(cos, eta, k) - 1.0).abs() < 1e-6, "{cos} {eta} {k}");
                }
            }
            // Nothing to speak of inside: no wave goes on there.
            assert_eq!(conductor(cos, 1e-30, 1e-30), 1.0);
            assert_eq!(conductor(cos, 0.0, 0.0), 1.0);
        }
    }
}
