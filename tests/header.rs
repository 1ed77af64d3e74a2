//! The header of EXR files: what OpenEXR itself names, as other programs read it.

use crate::common;
use bhs::header;
use bhs::lang::BuiltScene;
use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;
use glam::{DVec2, DVec3};
use std::io::Cursor;

/// The header of the file of a picture of `built`.
fn header_of(built: &BuiltScene) -> Header {
    let rendered = common::render(built);
    let mut bytes = Cursor::new(Vec::new());
    let attributes = header::attributes(&header::Facts::of(built), &rendered);
    rendered.frame.picture().write_exr(&mut bytes, &attributes).expect("in memory");
    bytes.set_position(0);
    let meta = exr::meta::MetaData::read_from_buffered(bytes, false).expect("an EXR file");
    meta.headers[0].clone()
}

/// `(p, 1)` times a matrix, as OpenEXR means it: a row vector from the left, rows one after the other; divided by the fourth coordinate.
fn times(p: DVec3, m: &[f32; 16]) -> DVec3 {
    let column = |j: usize| (0..4).map(|i| [p.x, p.y, p.z, 1.0][i] * f64::from(m[4 * i + j])).sum::<f64>();
    DVec3::new(column(0), column(1), column(2)) / column(3)
}

/// A scene far from the world's origin, so that render space is another one, seen by `camera`.
fn scene(camera: &str) -> String {
    format!(
        r#"
        Scale -1 1 1
        LookAt 1001 52 -7  1000 50 0  0.1 1 0
        {camera}
        Film "rgb" "integer xresolution" 64 "integer yresolution" 48 "float cropwindow" [0.25 1 0 1]
        Sampler "sobol" "integer pixelsamples" 1
        Option "integer seed" 12345678901
        WorldBegin
        LightSource "infinite" "float L" 1
        Translate 1000 50 0
        Shape "sphere" "float radius" 3
    "#
    )
}

const CAMERAS: [&str; 3] = [
    "Camera \"perspective\" \"float fov\" 40",
    "Camera \"perspective\" \"float screenwindow\" [-0.2 0.9 -0.4 0.3] \"float lensradius\" 0.1",
    "Camera \"orthographic\" \"float screenwindow\" [-5 4 -3 3]",
];

#[test]
fn matrices_put_points_where_the_camera_sees_them() {
    for camera in CAMERAS {
        let built = common::build(&scene(camera));
        let header = header_of(&built);
        let to_camera = header.own_attributes.world_to_camera.expect("worldToCamera");
        let to_ndc = header.own_attributes.world_to_normalized_device.expect("worldToNDC");
        assert!(built.scene.world.origin.length() > 100.0, "render space is another one");
        for raster in [DVec2::new(16.0, 0.0), DVec2::new(63.5, 47.5), DVec2::new(30.25, 11.75)] {
            // The middle of the lens.
            let ray = built.camera.ray(raster, glam::Vec2::splat(0.5));
            for distance in [1.0, 6.0, 40.0] {
                let point = ray.origin + distance * ray.direction + built.scene.world.origin;
                // The lens makes lines of other pixels sharp; a point on the axis of the lens is where it is without one.
                let seen = times(point, &to_ndc);
                let pixel = DVec2::new(seen.x * 64.0, seen.y * 48.0);
                assert!((pixel - raster).length() < 0.05, "{camera} {raster} {distance}: {pixel}");
                let in_camera = times(point, &to_camera);
                assert!(in_camera.z > 0.0 && (in_camera.z <= distance * 1.001), "{camera}: {in_camera}");
                // Right of the middle and above it.
                if camera == CAMERAS[0] {
                    assert_eq!((in_camera.x > 0.0, in_camera.y > 0.0), (raster.x > 32.0, raster.y < 24.0), "{in_camera}");
                }
            }
        }
    }
}

#[test]
fn a_spherical_camera_has_a_place_and_no_picture_plane() {
    let built = common::build(&scene("Camera \"spherical\""));
    let header = header_of(&built);
    let to_camera = header.own_attributes.world_to_camera.expect("worldToCamera");
    assert!(times(built.camera.position() + built.scene.world.origin, &to_camera).length() < 1e-3);
    assert_eq!(header.own_attributes.world_to_normalized_device, None);
}

#[test]
fn standard_attributes_have_their_standard_names_and_types() {
    let built = common::build(&scene(CAMERAS[0]));
    let before = chrono::Local::now().naive_local();
    let header = header_of(&built);
    let after = chrono::Local::now().naive_local();
    let c = header.shared_attributes.chromaticities.expect("chromaticities");
    let all = [c.red, c.green, c.blue, c.white].map(|v| [v.0, v.1]);
    assert_eq!(all, [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);
    let date = header.own_attributes.capture_date.as_ref().expect("capDate").to_string();
    let date = chrono::NaiveDateTime::parse_from_str(&date, "%Y:%m:%d %H:%M:%S").expect("YYYY:MM:DD hh:mm:ss");
    assert!(before - chrono::TimeDelta::seconds(1) <= date && date <= after, "{before} {date} {after}");
    assert_eq!(header.own_attributes.utc_offset, Some(-chrono::Local::now().offset().local_minus_utc() as f32));
    let comments = header.own_attributes.comments.as_ref().expect("comments").to_string();
    assert!(comments.contains("1 samples a pixel by `path` along `straight`"), "{comments}");
    let other = |name: &str| header.own_attributes.other.get(&exr::prelude::Text::from(name)).cloned();
    assert_eq!(other("bhs:seed"), Some(AttributeValue::F64(12_345_678_901.0)));
    assert_eq!((other("bhs:samplesNotFinite"), other("bhs:seedDigits")), (Some(AttributeValue::F64(0.0)), None));
    // Beyond the whole numbers that its type holds, the digits stand beside the number.
    let large = scene(CAMERAS[0]).replace("12345678901", "9007199254740993");
    let header = header_of(&common::build(&large));
    let digits = header.own_attributes.other.get(&exr::prelude::Text::from("bhs:seedDigits")).cloned();
    assert_eq!(digits, Some(AttributeValue::Text("9007199254740993".into())));
}

#[test]
fn a_file_has_the_names_that_other_programs_look_for() {
    let built = common::build(&scene(CAMERAS[0]));
    let rendered = common::render(&built);
    let mut bytes = Cursor::new(Vec::new());
    let attributes = header::attributes(&header::Facts::of(&built), &rendered);
    rendered.frame.picture().write_exr(&mut bytes, &attributes).expect("in memory");
    let bytes = bytes.into_inner();
    for (name, kind) in [
        ("chromaticities", "chromaticities"),
        ("worldToCamera", "m44f"),
        ("worldToNDC", "m44f"),
        ("capDate", "string"),
        ("utcOffset", "float"),
        ("comments", "string"),
        ("bhs:seed", "double"),
    ] {
        let entry = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat();
        assert!(bytes.windows(entry.len()).any(|w| w == entry), "{name}");
    }
}
