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

/// The direction that mirrors `w` at a surface with the unit normal `n`.
pub fn reflect(w: Vec3, n: Vec3) -> Vec3 {
    2.0 * w.dot(n) * n - w
}
