use super::*;
use bhs_core::sampling::{mix64, unit_f32};

fn number(i: u64) -> f32 {
    unit_f32((mix64(i) >> 32) as u32)
}

fn guide() -> Guide {
    Guide::new(Aabb { min: DVec3::ZERO, max: DVec3::new(1.0, 2.0, 3.0) })
}

const POINT: DVec3 = DVec3::new(0.3, 0.4, 2.5);

/// Axes around a normal that is turned about it, and normals of all kinds.
fn axes(i: u64) -> [DVec3; 3] {
    let n = DVec3::from_array([0, 1, 2].map(|k| f64::from(number(5 * i + k)) - 0.5)).normalize();
    let (s, t) = n.any_orthonormal_pair();
    let (sin, cos) = f64::from(number(5 * i + 4) * 6.0).sin_cos();
    [s * cos + t * sin, t * cos - s * sin, n]
}

/// Much light from one side of the vertical, some from everywhere.
fn light(axes: &[DVec3; 3], wi: Vec3) -> f32 {
    let world = axes[0] * f64::from(wi.x) + axes[1] * f64::from(wi.y) + axes[2] * f64::from(wi.z);
    if world.x > 0.0 { 1e9 } else { 1e8 }
}

/// Lessons of a floor that looks up.
fn trained(lessons: u64) -> Guide {
    let mut guide = guide();
    let axes = [DVec3::Z, DVec3::X, DVec3::Y];
    for stage in 0..4 {
        let place = guide.place_at(POINT, axes, 1.0);
        let learned: Vec<Lesson> = (stage * lessons..(stage + 1) * lessons)
            .filter_map(|i| {
                let drawn = place.sample(Vec2::new(number(2 * i), number(2 * i + 1)));
                let lesson = place.lesson(drawn.wi, drawn.density * drawn.wi.z.abs() * FRAC_1_PI)?;
                assert!((lesson.density / drawn.density - 1.0).abs() < 1e-4);
                Some(Lesson { radiance: light(&axes, drawn.wi), ..lesson })
            })
            .collect();
        guide.learn(&learned);
        guide.refine();
    }
    guide
}

#[test]
fn directions_have_the_density_that_is_said_whatever_the_axes() {
    let warp = Warp::new(&std::array::from_fn(|i| 0.01 + number(i as u64)));
    let guide = guide();
    for i in 0..2000 {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let place = GuidedHemisphere { warp: &warp, ..guide.place_at(POINT, axes(i), side) };
        let drawn = place.sample(Vec2::new(number(7 * i), number(7 * i + 1)));
        assert!((drawn.wi.length() - 1.0).abs() < 1e-5 && drawn.wi.z * side >= 0.0);
        // Beside the edge of a square, rounding may decide for the other one.
        let near = [-1e-4, 1e-4].iter().any(|d| {
            let moved = (drawn.wi + Vec3::new(*d, -*d, 0.0)).normalize();
            place.density(moved) != place.density(drawn.wi)
        });
        assert!(near || place.density(drawn.wi) == drawn.density, "{i}");
        // Other axes around the same normal.
        let [s, t, n] = axes(i);
        let turned = GuidedHemisphere { warp: &warp, ..guide.place_at(POINT, [t, -s, n], side) };
        let wi = Vec3::new(drawn.wi.y, -drawn.wi.x, drawn.wi.z);
        assert!(near || turned.density(wi) == drawn.density, "{i}");
    }
}

#[test]
fn what_is_learned_is_the_light() {
    let guide = trained(20_000);
    let axes = [DVec3::Z, DVec3::X, DVec3::Y];
    let place = guide.place_at(POINT, axes, 1.0);
    // Half of the hemisphere has ten times the light of the other half.
    let [bright, dim] = [1.0, 0.1].map(|light| 1.0 - MIXING_PROBABILITY + MIXING_PROBABILITY * light / 0.55);
    for i in 0..500 {
        let wi = cosine_hemisphere(Vec2::new(number(3 * i), number(3 * i + 1)));
        let expected = if light(&axes, wi) == 1e9 { bright } else { dim };
        let found = place.density(wi);
        assert!((found / expected - 1.0).abs() < 0.2, "{wi}: {found} {expected}");
    }
    // Nothing is known of another place, nor of the other side.
    for other in [guide.place_at(DVec3::ONE, axes, 1.0), guide.place_at(POINT, axes, -1.0)] {
        assert_eq!(other.density(Vec3::new(0.0, 0.6, 0.8)), 1.0);
    }
}

#[test]
fn where_little_was_learned_larger_cells_say_what_is_known() {
    // All around one place, so that no small cell has enough lessons, but a large one has.
    let mut guide = guide();
    let axes = [DVec3::Z, DVec3::X, DVec3::Y];
    let at = |i: u64| DVec3::new(0.5, 0.5, 1.0) + DVec3::from_array([0, 1, 2].map(|k| 0.2 * f64::from(number(9 * i + k)) - 0.1));
    let lessons: Vec<Lesson> = (0..4000)
        .filter_map(|i| {
            let place = guide.place_at(at(i), axes, 1.0);
            let wi = cosine_hemisphere(Vec2::new(number(9 * i + 3), number(9 * i + 4)));
            Some(Lesson { radiance: light(&axes, wi), ..place.lesson(wi, wi.z * FRAC_1_PI)? })
        })
        .collect();
    guide.learn(&lessons);
    guide.refine();
    let slots = |i| guide.place_at(at(i), axes, 1.0).slot;
    assert!((0..100).any(|i| slots(i) != slots(0)), "there are several small cells");
    for i in 0..100 {
        let place = guide.place_at(at(i), axes, 1.0);
        let [bright, dim] = [-0.8, 0.8].map(|x| place.density(Vec3::new(0.0, x, 0.6)).max(place.density(Vec3::new(x, 0.0, 0.6))));
        assert!(bright.max(dim) > 1.1, "{i}: {bright} {dim}");
    }
}
