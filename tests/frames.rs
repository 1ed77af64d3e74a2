//! Local frames and the counting of light: areas, solid angles, and what falls into the hole.

use crate::common;
use crate::common::lights::random;
use crate::common::physics::rgb_of;
use bhs_core::geometry::Geometry;
use bhs_core::light::Emission;
use bhs_core::ray::Arrival;
use bhs_engine::scene::Scene;
use glam::{DVec3, Vec2};
use std::f64::consts::{PI, TAU};

fn direction(u: f64, v: f64) -> DVec3 {
    let z = 2.0 * u - 1.0;
    let (sin, cos) = (TAU * v).sin_cos();
    DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
}

/// The integral of `g(f)` over the proper area of a sphere of radius `radius`, whose middle is `off` from the hole, rs = 1: with the polar
/// angle from the axis through the hole, `dl^2 = (R^2 + (1/f - 1) (dr/dtheta)^2) dtheta^2` (midpoint rule).
fn over_sphere(radius: f64, off: f64, g: impl Fn(f64) -> f64) -> f64 {
    let n = 20_000;
    let sum: f64 = (0..n)
        .map(|i| {
            let theta = PI * (f64::from(i) + 0.5) / f64::from(n);
            let r = (off * off + radius * radius + 2.0 * off * radius * theta.cos()).sqrt();
            let (f, dr) = (1.0 - 1.0 / r, -off * radius * theta.sin() / r);
            TAU * radius * theta.sin() * (radius * radius + (1.0 / f - 1.0) * dr * dr).sqrt() * g(f)
        })
        .sum();
    sum * PI / f64::from(n)
}

/// The same of a rectangle at the distance `d` from the hole, of points `(x, y)` in its plane from the foot of that: by
/// `sqrt(det g) = sqrt(1 + (1/f - 1) |grad r|^2)`.
fn over_rectangle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], d: f64, g: impl Fn(f64) -> f64) -> f64 {
    let n = 1000;
    let mut sum = 0.0;
    for i in 0..n * n {
        let x = x0 + (x1 - x0) * (f64::from(i % n) + 0.5) / f64::from(n);
        let y = y0 + (y1 - y0) * (f64::from(i / n) + 0.5) / f64::from(n);
        let r2 = x * x + y * y + d * d;
        let f = 1.0 - 1.0 / r2.sqrt();
        sum += (1.0 + (1.0 / f - 1.0) * (x * x + y * y) / r2).sqrt() * g(f);
    }
    sum * (x1 - x0) * (y1 - y0) / f64::from(n * n)
}

const VIEW: &str = "LookAt 0 0 3  0 0 0  0 1 0\nCamera \"perspective\"\n";

#[test]
fn a_lamp_emits_pi_l_over_its_local_area() {
    let cases = [
        (r#"Translate 0 0 1.9  Shape "sphere" "float radius" 0.8"#, over_sphere(0.8, 1.9, |_| 1.0)),
        (r#"Shape "sphere" "float radius" 1.1"#, over_sphere(1.1, 0.0, |_| 1.0)),
        (
            r#"Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-0.5 -1 1.2  1.5 -1 1.2  1.5 2 1.2  -0.5 2 1.2]"#,
            over_rectangle([-0.5, 1.5], [-1.0, 2.0], 1.2, |_| 1.0),
        ),
    ];
    for (shape, area) in cases {
        let built = common::build(&format!(
            "{VIEW}WorldBegin\nBlackHole \"schwarzschild\" \"float rs\" 1\nAreaLightSource \"diffuse\" \"float L\" 7\n{shape}"
        ));
        let scene = &built.scene;
        let n = 1_500_000;
        let (mut power, mut local_area) = (0.0, 0.0);
        for i in 0..n {
            // A point uniform by chart area, a direction uniform by chart solid angle; their measures turned into local ones.
            let u = Vec2::new(random(i, 0) as f32, random(i, 1) as f32);
            let point = scene.sample_light(None, random(i, 2) as f32, u).expect("a lamp");
            let bhs_engine::light_sampling::LightSource::Surface { emitter, normal, uv, .. } = point.source else {
                panic!("no lamp")
            };
            let frame = point.observer.frame;
            let chart = direction(random(i, 3), random(i, 4));
            let cos = frame.local_normal(normal).dot(frame.local_direction(chart));
            let clock_rate = point.observer.clock_rate() as f32;
            let (point_at, cos_theta, lambda_nm) = (point.point, cos as f32, [500.0; 4]);
            let at = Emission { uv, point: point_at, time: 0.0, cos_theta, lambda_nm, clock_rate };
            let emitted = f64::from(scene.light_sampler.emitters[emitter as usize].light.radiance(&at)[0]);
            let area = frame.area_factor(normal) / point.pdf;
            power += emitted * cos * area * frame.solid_angle_factor(chart) * 4.0 * PI;
            local_area += area;
        }
        let (power, local_area) = (power / n as f64, local_area / n as f64);
        eprintln!("{shape}: area {:.5}, power {:.5} of the true one", local_area / area, power / (7.0 * PI * area));
        // Standard deviations of one sample are some 0.5 and 1.5 of the mean.
        assert!((local_area / area - 1.0).abs() < 1.5e-3, "{shape}: local area {local_area}, integrated {area}");
        assert!((power / (7.0 * PI * area) - 1.0).abs() < 5e-3, "{shape}: power {power}, {}", 7.0 * PI * area);
    }
}

/// A closed room, corners at the given places, with an octahedron and a ball beside the hole at the origin.
const ROOM: &str = r#"
    Shape "trianglemesh" "point3 P" [-3 -2.5 -3.2  3 -2.5 -3.2  -3 2.5 -3.2  3 2.5 -3.2  -3 -2.5 4  3 -2.5 4  -3 2.5 4  3 2.5 4]
        "integer indices" [0 2 3  0 3 1  4 5 7  4 7 6  0 1 5  0 5 4  2 6 7  2 7 3  0 4 6  0 6 2  1 3 7  1 7 5]
    Translate 1.2 0 -2  Shape "sphere" "float radius" 0.7
"#;

/// The integral of `g(f)` over the surfaces of [`ROOM`], and over the ball alone.
fn over_room(g: impl Fn(f64) -> f64 + Copy) -> (f64, f64) {
    let (x, y, z) = ([-3.0, 3.0], [-2.5, 2.5], [-3.2, 4.0]);
    let walls = over_rectangle(x, y, 3.2, g)
        + over_rectangle(x, y, 4.0, g)
        + 2.0 * over_rectangle(x, z, 2.5, g)
        + 2.0 * over_rectangle(y, z, 3.0, g);
    let ball = over_sphere(0.7, 5.44f64.sqrt(), g);
    (walls + ball, ball)
}

/// Point `i` of all emitters, with the weight of its measure `dA_local/f`, and a ray from it that follows the cosine of the local
/// frame. Walls shine inwards, to the side of the camera's half of space; a ball outwards.
fn leave(scene: &Scene, i: u64) -> (f64, bhs_core::ray::Ray) {
    let u = Vec2::new(random(i, 0) as f32, random(i, 1) as f32);
    let point = scene.sample_light(None, random(i, 2) as f32, u).expect("a lamp");
    let bhs_engine::light_sampling::LightSource::Surface { emitter, normal, .. } = point.source else { panic!("no lamp") };
    let is_wall =
        matches!(scene.world.geometries[scene.light_sampler.emitters[emitter as usize].geometry as usize], Geometry::Mesh(_));
    let normal = if is_wall && normal.dot(point.point) > 0.0 { -normal } else { normal };
    let frame = point.observer.frame;
    let local = (direction(random(i, 3), random(i, 4)) + frame.local_normal(normal)).normalize();
    let clock_rate = point.observer.clock_rate();
    let weight = frame.area_factor(normal) / point.pdf / (clock_rate * clock_rate);
    (weight, bhs_core::ray::Ray::new(point.point + normal * 5e-6, frame.chart_direction(local)))
}

#[test]
fn of_the_light_of_a_closed_room_what_falls_in_is_27_pi_rs2_over_its_area() {
    // Along a ray dA cos domega / f (local) is constant. Light that fills all directions from all walls falls into the hole from all
    // directions within b_crit: 4 pi x pi b_crit^2 of pi x integral(dA/f), whatever the room and what is in it.
    let (area, _) = over_room(|f| 1.0 / f);
    let expected = 4.0 * PI * 6.75 / area;
    for integrator in ["schwarzschild-exact", "schwarzschild-adaptive", "schwarzschild-rk4"] {
        let built = common::build(&format!(
            "Integrator \"{integrator}\"\n{VIEW}WorldBegin\nBlackHole \"schwarzschild\" \"float rs\" 1\nAreaLightSource \"diffuse\"\n{ROOM}"
        ));
        let scene = &built.scene;
        let (mut sum, mut fallen, n) = (0.0, 0.0, 300_000);
        for i in 0..n {
            let (weight, ray) = leave(scene, i);
            sum += weight;
            match scene.integrator.trace(&scene.world, &ray).arrival {
                Arrival::Captured => fallen += weight,
                Arrival::Surface(_) => {}
                other => panic!("{integrator}: {other:?} from {ray:?}"),
            }
        }
        let (area_found, found) = (sum / n as f64, fallen / sum);
        eprintln!("{integrator}: area {:.4}, fallen {:.4} of what must", area_found / area, found / expected);
        assert!((area_found / area - 1.0).abs() < 2e-3, "{integrator}: {area_found} {area}");
        // Binomial: 300,000 rays of which some 40 % fall in.
        assert!((found / expected - 1.0).abs() < 1.2e-2, "{integrator}: {found} {expected}");
    }
}

#[test]
fn a_white_furnace_lacks_what_fell_into_the_hole() {
    // Walls of albedo rho that emit 1 - rho, no redshift. With roulette at every bounce a path carries 1 until it is absorbed by a wall or
    // by the hole: so by reciprocity the picture is 1 minus the share of the paths that were captured. Light sampling must agree.
    let picture = |transport: &str| {
        let built = common::build(&format!(
            r#"
            {transport}
            Sampler "sobol" "integer pixelsamples" 8192
            Film "rgb" "integer xresolution" 4 "integer yresolution" 4
            Integrator "schwarzschild-adaptive" "float tolerance" 1e-3
            LookAt 0 0 3  0 0.3 0  0 1 0
            Camera "perspective" "float fov" 100
            WorldBegin
            BlackHole "schwarzschild" "float rs" 1 "bool redshift" false
            Material "diffuse" "spectrum reflectance" 0.6
            AreaLightSource "diffuse" "spectrum L" 0.4 "bool twosided" true
            {ROOM}
            "#
        ));
        let rendered = common::render(&built);
        let picture = rendered.frame.picture();
        let green = picture.data.iter().skip(1).step_by(3).map(|v| f64::from(*v)).sum::<f64>() / 16.0;
        let white = rgb_of(|_| 1.0, [360.0, 830.0], 4)[1];
        (green / white, rendered.counters.captured as f64 / rendered.counters.paths as f64)
    };
    let (lit, captured) =
        picture(r#"LightTransport "path" "integer maxdepth" 1000 "integer rrdepth" 0 "bool lightsampling" false"#);
    let (sampled, _) = picture(r#"LightTransport "path" "integer maxdepth" 40 "integer rrdepth" 40"#);
    eprintln!("lit {lit:.5}, captured {captured:.5}, by light sampling {sampled:.5}");
    // 131,072 paths: 0.4 emitted at a time against one capture in the end.
    assert!(captured > 0.2 && (1.0 - lit - captured).abs() < 3e-3, "{lit} {captured}");
    assert!((1.0 - sampled - captured).abs() < 3e-3, "{sampled} {captured}");
}
