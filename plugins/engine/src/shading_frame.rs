//! Shading frames that lie along the texture coordinates of a surface: for materials that say `is_oriented`.

use bhs_core::geometry::SurfaceTangents;
use bhs_core::material::Tangents;
use bhs_core::observer::Observer;
use glam::DVec3;

/// The axes of a shading frame with the shading normal `ns` whose x lies along u, and the tangents in it. Lengths are those that the observer
/// measures, at rest, as its normals are.
#[inline(never)]
pub(crate) fn oriented(observer: &Observer, surface: &SurfaceTangents, ns: DVec3) -> ([DVec3; 3], Tangents) {
    let local = |v: DVec3| observer.frame.apply(v);
    let across = |v: DVec3| v - ns * ns.dot(v);
    let [mut along_u, mut along_v] = [surface.dpdu, surface.dpdv].map(|v| across(local(v)));
    let s = along_u.try_normalize().unwrap_or_else(|| {
        (along_u, along_v) = ns.any_orthonormal_pair();
        along_u
    });
    let axes = [s, ns.cross(s), ns];
    let in_frame = |v: DVec3| DVec3::from_array(axes.map(|a| a.dot(v))).as_vec3();
    let tangents = Tangents {
        point: [along_u, along_v].map(in_frame),
        normal: [surface.dndu, surface.dndv].map(|v| in_frame(local(v))),
        world: [surface.dpdu.as_vec3(), surface.dpdv.as_vec3()],
    };
    (axes, tangents)
}
