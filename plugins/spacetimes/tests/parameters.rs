//! What scenes may write, and what they are told when they may not.

mod common;

use bhs_core::spacetime::{Ball, Class, Place, Side};
use common::{Given, build, build_under, index_of};
use glam::{DAffine3, DQuat, DVec3};

/// The codes and messages of what is wrong, and whether a spacetime came of it.
fn wrong(transform: DAffine3, name: &str, params: Given) -> Vec<String> {
    build_under(transform, name, params).1.into_iter().map(|d| d.message).collect()
}

#[test]
fn bad_parameters_are_told() {
    let holes = |centers: &'static [f64], masses: &'static [f64]| [("point3 centers", centers), ("float masses", masses)];
    let cases: &[(&str, Given, &str)] = &[
        ("schwarzschild", &[], "`schwarzschild` needs the parameter `rs`"),
        ("schwarzschild", &[("float rs", &[-1.0])], "`rs` is negative"),
        ("schwarzschild", &[("float rs", &[f64::INFINITY])], "`rs` is out of range"),
        ("schwarzschild", &[("float rs", &[f64::NAN])], "`rs` is out of range"),
        ("schwarzschild", &[("float rs", &[1e300])], "`schwarzschild` is out of range"),
        ("schwarzschild", &[("float rs", &[1.0]), ("float charge", &[0.1])], "unknown parameter `charge`"),
        (
            "schwarzschild",
            &[("float rs", &[1.0]), ("point3 center", &[0.0, 0.0, f64::INFINITY])],
            "`schwarzschild` is out of range",
        ),
        ("reissner-nordstrom", &[("float rs", &[1.0]), ("float charge", &[1.1])], "`charge` is out of range"),
        ("reissner-nordstrom", &[("float rs", &[1.0]), ("float charge", &[-0.1])], "`charge` is out of range"),
        ("majumdar-papapetrou", &holes(&[0.0; 3], &[]), "`masses` and `centers` differ in number"),
        ("majumdar-papapetrou", &holes(&[0.0; 3], &[1.0, 2.0]), "`masses` and `centers` differ in number"),
        ("majumdar-papapetrou", &holes(&[0.0; 4], &[1.0]), "`centers` expects a multiple of 3 numbers"),
        ("majumdar-papapetrou", &holes(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], &[1.0, -1.0]), "`masses` is negative"),
        ("majumdar-papapetrou", &holes(&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], &[1.0, 1.0]), "two holes coincide"),
        ("ellis", &[("float throat", &[-0.1])], "`throat` is negative"),
        ("dneg", &[("float throat", &[1.0]), ("float length", &[-1.0]), ("float lensingwidth", &[0.1])], "`length` is negative"),
        ("dneg", &[("float throat", &[1.0]), ("float lensingwidth", &[0.0])], "`lensingwidth` is 0"),
        ("dneg", &[("float throat", &[1.0]), ("float lensingwidth", &[1e-9])], "`lensingwidth` is out of range"),
        ("dneg", &[("float throat", &[1.0]), ("float lensingwidth", &[1e4])], "`lensingwidth` is out of range"),
        (
            "dneg",
            &[("float throat", &[1.0]), ("float length", &[100.0]), ("float lensingwidth", &[0.1])],
            "`length` is out of range",
        ),
        ("dneg", &[("float throat", &[1.0])], "`dneg` needs the parameter `lensingwidth`"),
    ];
    for (name, params, message) in cases {
        assert_eq!(wrong(DAffine3::IDENTITY, name, params), [*message], "{name} {params:?}");
    }
}

#[test]
fn stretched_spacetimes_are_refused() {
    let stretched = DAffine3::from_scale(DVec3::new(1.0, 2.0, 1.0));
    let cases: &[(&str, Given)] = &[
        ("schwarzschild", &[("float rs", &[1.0])]),
        ("majumdar-papapetrou", &[("point3 centers", &[0.0; 3]), ("float masses", &[1.0])]),
        ("ellis", &[("float throat", &[1.0])]),
        ("dneg", &[("float throat", &[1.0]), ("float lensingwidth", &[0.1])]),
    ];
    for (name, params) in cases {
        assert_eq!(wrong(stretched, name, params), [format!("the current transform stretches `{name}`")]);
        assert!(build_under(stretched, name, params).0.is_none());
    }
    // Flat space has no lengths.
    assert!(wrong(stretched, "minkowski", &[]).is_empty());
}

#[test]
fn lengths_scale_and_places_move_with_the_transform() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(2.5), turn, DVec3::new(1.0, -3.0, 0.5));
    let center = [0.4, 0.1, -0.2];
    let moved = transform.transform_point3(center.into());
    let hole = build_under(
        transform,
        "reissner-nordstrom",
        &[("point3 center", &center), ("float rs", &[0.4]), ("float charge", &[0.5])],
    );
    let Class::Spherical(hole) = hole.0.as_ref().unwrap().class() else { panic!("a round hole") };
    assert!((hole.center - moved).length() < 1e-14 && (hole.rs - 1.0).abs() < 1e-14);
    assert!((hole.charge_squared - 0.0625).abs() < 1e-14);

    let throat = build_under(transform, "ellis", &[("point3 center", &center), ("float throat", &[0.4])]).0.unwrap();
    let throat = index_of(throat.as_ref()).unwrap().throat().unwrap();
    assert!((throat.center - moved).length() < 1e-14 && (throat.radius - 0.5).abs() < 1e-14);

    let hole = build_under(transform, "majumdar-papapetrou", &[("point3 centers", &center), ("float masses", &[0.4])]).0.unwrap();
    let [Ball { center, radius }] = hole.captures()[..] else { panic!("one hole") };
    assert!((center - moved).length() < 1e-14 && (radius - 1.0).abs() < 1e-14);
}

#[test]
fn without_mass_space_is_flat() {
    let cases: &[(&str, Given)] = &[
        ("minkowski", &[]),
        ("schwarzschild", &[("float rs", &[0.0])]),
        ("reissner-nordstrom", &[("float rs", &[0.0]), ("float charge", &[1.0])]),
        ("majumdar-papapetrou", &[("point3 centers", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), ("float masses", &[0.0, 0.0])]),
        ("majumdar-papapetrou", &[("point3 centers", &[]), ("float masses", &[])]),
        ("ellis", &[("float throat", &[0.0])]),
        ("dneg", &[("float throat", &[0.0]), ("float length", &[1.0]), ("float lensingwidth", &[0.1])]),
    ];
    for (name, params) in cases {
        let flat = build(name, params);
        assert!(matches!(flat.class(), Class::Flat), "{name}");
        assert!(flat.captures().is_empty() && flat.at(Place::near(DVec3::ZERO)).is_some(), "{name}");
        // Of a wormhole two sides remain.
        assert_eq!(flat.at(Place { x: DVec3::X, side: Side::Far }).is_some(), ["ellis", "dneg"].contains(name));
    }
    // Holes without mass beside others do nothing.
    let two = build("majumdar-papapetrou", &[("point3 centers", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), ("float masses", &[0.0, 1.0])]);
    assert_eq!(two.captures().len(), 1);
}

#[test]
fn nobody_stands_in_a_hole() {
    let rn = build("reissner-nordstrom", &[("float rs", &[1.0]), ("float charge", &[0.6])]);
    // 0.5 (1 + sqrt(1 - 0.36))
    assert!((rn.captures()[0].radius - 0.9).abs() < 1e-15);
    assert!(rn.at(Place::near(DVec3::X * 0.9)).is_none() && rn.at(Place::near(DVec3::X * 0.900_001)).is_some());
    let mp = build("majumdar-papapetrou", &[("point3 centers", &[0.0; 3]), ("float masses", &[1.0])]);
    assert!(mp.at(Place::near(DVec3::ZERO)).is_none() && mp.at(Place::near(DVec3::X * 1e-3)).is_some());
    let ellis = build("ellis", &[("float throat", &[1.0])]);
    assert!(ellis.at(Place::near(DVec3::ZERO)).is_none() && ellis.at(Place::near(DVec3::X * 0.499)).is_none());
    assert!(ellis.at(Place { x: DVec3::X * 0.5, side: Side::Far }).is_some());
}
