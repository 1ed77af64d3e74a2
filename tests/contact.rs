//! Glass that stands on a floor, sheets of glass that touch, lamps just behind and before a surface: what is seen, against closed forms.

use crate::common::lights::mean;

/// Reflectance of glass of index 1.5 at normal incidence.
const R: f64 = 0.04;

/// How much light passes, and how much is thrown back by, so many surfaces of glass one behind the other (all reflections counted).
fn pile(surfaces: f64) -> (f64, f64) {
    let passed = (1.0 - R) / (1.0 + (surfaces - 1.0) * R);
    (passed, 1.0 - passed)
}

/// A picture of 8 pixels' width from above, nearly straight down.
fn camera(more: &str) -> String {
    format!(
        r#"{more}
        LookAt 0 4 0.001  0 0 0  0 1 0
        Camera "perspective" "float fov" 10
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8
        Sampler "sobol" "integer pixelsamples" 256
        LightTransport "path" "integer maxdepth" 40 "integer rrdepth" 40
        WorldBegin
        "#
    )
}

/// The faces of a block from `lo` to `hi` above the middle.
fn block([half, lo, hi]: [f64; 3]) -> String {
    format!(
        r#"Shape "trianglemesh" "integer indices" [0 2 1 0 3 2  4 5 6 4 6 7  0 1 5 0 5 4  3 6 2 3 7 6  0 4 7 0 7 3  1 2 6 1 6 5] "point3 P" [
            -{half} {lo:?} -{half}  {half} {lo:?} -{half}  {half} {hi:?} -{half}  -{half} {hi:?} -{half}
            -{half} {lo:?} {half}  {half} {lo:?} {half}  {half} {hi:?} {half}  -{half} {hi:?} {half}]
        "#
    )
}

/// A square that faces up, or down.
fn square(half: f64, y: f64, up: bool) -> String {
    let corners = if up { "0 1 2 0 2 3" } else { "0 2 1 0 3 2" };
    format!(
        r#"Shape "trianglemesh" "integer indices" [{corners}]
            "point3 P" [-{half} {y:?} -{half}  -{half} {y:?} {half}  {half} {y:?} {half}  {half} {y:?} -{half}]
        "#
    )
}

const GLASS: &str = "Material \"dielectric\"\n";
const BLACK: &str = "Material \"diffuse\" \"float reflectance\" 0\n";
const SKY: &str = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";

/// Of glass on a black floor under a white sky, what the glass throws back is seen, from its upper side or from both.
fn is_glass_on_black(text: &str) {
    let seen = mean(text);
    let ok = [1.0, 2.0].into_iter().any(|surfaces| (seen - pile(surfaces).1).abs() < 0.006);
    assert!(ok, "{seen} in\n{text}");
}

#[test]
fn glass_on_a_floor_lets_no_light_through_the_floor() {
    let disk =
        |flip: &str| format!("AttributeBegin\n{flip}\nRotate -90 1 0 0\nShape \"disk\" \"float radius\" 5\nAttributeEnd\n");
    // Its middle lies in the plane; the second one is curved, and lies below but for the middle.
    let patch = "Shape \"bilinearmesh\" \"point3 P\" [-5 0 -5  5 0 -5  -5 0 5  5 0 5.0001]\n".to_owned();
    let tube = "AttributeBegin\nTranslate 0 -50 0\nShape \"cylinder\" \"float radius\" 50 \"float zmin\" -5 \"float zmax\" 5\nAttributeEnd\n";
    let floors = [
        square(5.0, 0.0, true),
        square(5.0, 0.0, false),
        square(5000.0, 0.0, true),
        disk(""),
        disk("ReverseOrientation"),
        patch,
        tube.to_owned(),
        "AttributeBegin\nTranslate 0 -50 0\nShape \"sphere\" \"float radius\" 50\nAttributeEnd\n".to_owned(),
        format!("ObjectBegin \"floor\"\n{}ObjectEnd\nObjectInstance \"floor\"\n", square(5.0, 0.0, true)),
    ];
    for floor in &floors {
        for gap in [0.0, 1e-7, 1e-6] {
            let (floor, glass) = (format!("{BLACK}{floor}"), format!("{GLASS}{}", block([0.5, gap, 1.0])));
            is_glass_on_black(&format!("{}{SKY}{floor}{glass}", camera("")));
            is_glass_on_black(&format!("{}{SKY}{glass}{floor}", camera("")));
        }
    }
}

#[test]
fn nor_does_glass_of_other_shapes_or_elsewhere() {
    let floor = format!("{BLACK}{}", square(5.0, 0.0, true));
    // A can of three surfaces that stands on the floor.
    let can = "Shape \"cylinder\" \"float radius\" 0.6 \"float zmin\" -0.5 \"float zmax\" 0.5
        Shape \"disk\" \"float radius\" 0.6 \"float height\" 0.5
        ReverseOrientation
        Shape \"disk\" \"float radius\" 0.6 \"float height\" -0.5";
    for gap in [0.0, 1e-7, 1e-6] {
        let at = 0.5 + gap;
        let glass = format!("{GLASS}AttributeBegin\nTranslate 0 {at:?} 0\nRotate -90 1 0 0\n{can}\nAttributeEnd\n");
        is_glass_on_black(&format!("{}{SKY}{floor}{glass}", camera("")));
    }
    // As an instance, and far from the world's origin.
    for gap in [0.0, 1e-6] {
        let glass = format!(
            // The object in coordinates of its own, wherever the world is moved to.
            "AttributeBegin\nIdentity\n{GLASS}ObjectBegin \"block\"\n{}ObjectEnd\nAttributeEnd\nTranslate 0 {gap:?} 0\nObjectInstance \"block\"\n",
            block([0.5, 0.0, 1.0])
        );
        is_glass_on_black(&format!("{}{SKY}{floor}{glass}", camera("")));
        let far = camera("").replace("LookAt 0 4 0.001  0 0 0", "LookAt 3e5 4 1000000.001  3e5 0 1e6");
        let far = far.replace("WorldBegin", "WorldBegin\nTranslate 3e5 0 1e6");
        is_glass_on_black(&format!("{far}{SKY}{floor}{glass}"));
    }
}

#[test]
fn nor_around_a_hole() {
    let floor = format!("{BLACK}{}", square(5.0, 0.0, true));
    for hole in ["[0 40 30] \"float rs\" 0.01", "[3 3 0] \"float rs\" 0.02"] {
        for integrator in ["adaptive", "exact", "rk4"] {
            for gap in [0.0, 1e-7, 1e-6] {
                let options = camera(&format!("Integrator \"schwarzschild-{integrator}\""));
                let hole = format!("BlackHole \"schwarzschild\" \"point3 center\" {hole} \"bool redshift\" false\n");
                is_glass_on_black(&format!("{options}{hole}{SKY}{floor}{GLASS}{}", block([0.5, gap, 1.0])));
            }
        }
    }
}

#[test]
fn sheets_of_glass_pass_the_same_light_in_contact_and_apart() {
    // A wide lamp below.
    let lamp = format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n{BLACK}{}AttributeEnd\n",
        square(4.0, -1.0, true)
    );
    for hole in ["", "BlackHole \"schwarzschild\" \"point3 center\" [0 40 30] \"float rs\" 0.01 \"bool redshift\" false\n"] {
        for gap in [0.0, 1e-7, 1e-6, 1e-3] {
            for sheets in [2u32, 5] {
                let pile_of = |one: &dyn Fn(f64, f64) -> String| {
                    (0..sheets).map(|i| f64::from(i) * (0.05 + gap)).map(|lo| one(lo, lo + 0.05)).collect::<String>()
                };
                let separate = pile_of(&|lo, hi| block([3.0, lo, hi]));
                let instances = "ObjectBegin \"sheet\"\n".to_owned()
                    + &block([3.0, 0.0, 0.05])
                    + "ObjectEnd\n"
                    + &pile_of(&|lo, _| {
                        format!("AttributeBegin\nTranslate 0 {lo:?} 0\nObjectInstance \"sheet\"\nAttributeEnd\n")
                    });
                for glass in [separate, instances] {
                    let text = format!("{}{hole}{lamp}{GLASS}{glass}", camera(""));
                    let (seen, right) = (mean(&text), pile(f64::from(2 * sheets)).0);
                    assert!((seen - right).abs() < 0.012, "{seen} instead of {right} in\n{text}");
                }
            }
        }
    }
}

#[test]
fn a_lamp_just_behind_a_surface_lights_nothing_before_it() {
    let seen = |hole: &str, ceiling: Option<f64>| {
        let lamp = format!(
            "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\n{BLACK}{}AttributeEnd\n",
            square(0.5, 1.0, false)
        );
        let ceiling = ceiling.map_or(String::new(), |y| format!("{BLACK}{}", square(3.0, y, false)));
        let camera = camera("").replace("LookAt 0 4 0.001  0 0 0", "LookAt 3 0.5 0  0 0 0");
        mean(&format!("{camera}{hole}Material \"diffuse\" \"float reflectance\" 1\n{}{ceiling}{lamp}", square(2.0, 0.0, true)))
    };
    for hole in ["", "BlackHole \"schwarzschild\" \"point3 center\" [0 40 30] \"float rs\" 0.01 \"bool redshift\" false\n"] {
        let open = seen(hole, None);
        assert!(open > 0.05, "{open}");
        for gap in [1e-6, 1e-5, 1e-4] {
            let (before, behind) = (seen(hole, Some(1.0 + gap)), seen(hole, Some(1.0 - gap)));
            assert!((before / open - 1.0).abs() < 0.02, "{before} instead of {open} with a ceiling {gap} behind the lamp");
            assert_eq!(behind, 0.0, "with a ceiling {gap} before the lamp");
        }
    }
}
