//! Lamps in the very plane of another surface are warned of, at both places; lamps beside one, or below it, are not.

use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;

/// The places (line and column) of the lamp and the other surface of each warning of a lamp in another surface's plane.
fn warnings(text: &str) -> Vec<[(usize, usize); 2]> {
    let mut sources = SourceMap::new();
    let built = match lang::load_text("test.bhs", text, &Registry::builtin(), &Overrides::default(), &mut sources) {
        Ok(built) => built,
        Err(found) => panic!("{}", bhs::report::render(&found, &sources, false)),
    };
    let place = |span: bhs_core::diagnostics::Span| sources.line_column(span.file, span.start);
    let coplanar = built.warnings.iter().filter(|w| w.code == "coplanar-light");
    coplanar.map(|w| [place(w.primary.as_ref().expect("the lamp").span), place(w.labels[0].span)]).collect()
}

/// A lamp, first, and the surfaces after it; each on a line of its own.
fn scene(lamp: &str, others: &[&str]) -> String {
    let lamp = format!("AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" true {lamp} AttributeEnd");
    format!("WorldBegin\n{lamp}\n{}", others.join("\n"))
}

/// A rectangle at the height y, as two triangles.
fn quad(x: [f64; 2], y: f64, z: [f64; 2]) -> String {
    let [x0, x1] = x;
    let [z0, z1] = z;
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2  0 2 3] \"point3 P\" [{x0} {y} {z0}  {x1} {y} {z0}  {x1} {y} {z1}  {x0} {y} {z1}]"
    )
}

fn disk(y: f64, parameters: &str) -> String {
    format!("AttributeBegin Translate 0 {y} 0 Rotate 90 1 0 0 Shape \"disk\" {parameters} AttributeEnd")
}

/// A grid of `n` times `n` pairs of triangles over -10..10 at the height y, in one mesh.
fn grid(n: usize, y: f64, leave_out: impl Fn(usize, usize) -> bool) -> String {
    let at = |i: usize| 20.0 * i as f64 / n as f64 - 10.0;
    let points: Vec<String> = (0..(n + 1) * (n + 1)).map(|i| format!("{} {y} {}", at(i % (n + 1)), at(i / (n + 1)))).collect();
    let mut indices = String::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).filter(|(i, j)| !leave_out(*i, *j)) {
        let a = j * (n + 1) + i;
        let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
        indices += &format!("{a} {b} {c} {a} {c} {d} ");
    }
    format!("Shape \"trianglemesh\" \"integer indices\" [{indices}] \"point3 P\" [{}]", points.join(" "))
}

#[test]
fn a_lamp_in_the_plane_of_a_ceiling_is_named_with_it() {
    // Heights that single precision rounds, and rooms of Cornell's size.
    for y in [0.0, 0.1, 2.7, 548.8, -17.3] {
        let ceiling = quad([-10.0, 10.0], y, [-10.0, 10.0]);
        let lamps = [
            quad([-1.0, 1.0], y, [-1.0, 1.0]),
            // Over the ceiling's edge, and larger than it.
            quad([9.0, 11.0], y, [-1.0, 1.0]),
            quad([-30.0, 30.0], y, [-30.0, 30.0]),
            disk(y, "\"float radius\" 0.7"),
            disk(y, "\"float radius\" 3 \"float innerradius\" 2.9 \"float phimax\" 30"),
        ];
        for lamp in &lamps {
            let [[light, other]]: [_; 1] =
                warnings(&scene(lamp, &[&ceiling])).try_into().unwrap_or_else(|w| panic!("{lamp}: {w:?}"));
            assert_eq!((light.0, other), (2, (3, 7)), "{lamp}");
        }
        // A disk for a ceiling, and one that the lamp covers.
        for radius in [12.0, 0.3] {
            let round = disk(y, &format!("\"float radius\" {radius}"));
            for lamp in [&lamps[0], &lamps[3]] {
                assert_eq!(warnings(&scene(lamp, &[&round])).len(), 1, "{radius} {lamp}");
            }
        }
    }
}

#[test]
fn a_lamp_beside_or_below_a_surface_is_fine() {
    let ceiling = quad([-10.0, 10.0], 5.5, [-10.0, 10.0]);
    for lamp in [
        quad([-1.0, 1.0], 5.4999, [-1.0, 1.0]),
        quad([-1.0, 1.0], 5.5001, [-1.0, 1.0]),
        disk(5.4999, "\"float radius\" 2"),
        // Beside it, with an edge in common or not.
        quad([10.0, 12.0], 5.5, [-10.0, 10.0]),
        quad([10.0, 12.0], 5.5, [-3.0, 3.0]),
        quad([11.0, 12.0], 5.5, [-3.0, 3.0]),
        // Upright, with its upper edge in the ceiling, or through it.
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [-1 5.5 0  1 5.5 0  0 3 0]".to_owned(),
        "Translate 0 5.5 0 Shape \"disk\"".to_owned(),
        // Touching it in a point.
        "Translate 0 4.5 0 Shape \"sphere\"".to_owned(),
        "Translate 0 5.5 0 Shape \"sphere\"".to_owned(),
    ] {
        assert!(warnings(&scene(&lamp, &[&ceiling])).is_empty(), "{lamp}");
    }
    // A hole cut for it, in one mesh and in four.
    let around = grid(20, 5.5, |i, j| (9..11).contains(&i) && (9..11).contains(&j));
    let lamp = quad([-1.0, 1.0], 5.5, [-1.0, 1.0]);
    assert!(warnings(&scene(&lamp, &[&around])).is_empty());
    let four = [
        quad([-10.0, -1.0], 5.5, [-10.0, 10.0]),
        quad([1.0, 10.0], 5.5, [-10.0, 10.0]),
        quad([-1.0, 1.0], 5.5, [-10.0, -1.0]),
        quad([-1.0, 1.0], 5.5, [1.0, 10.0]),
    ];
    assert!(warnings(&scene(&lamp, &four.each_ref().map(String::as_str))).is_empty());
    // A ring around a round lamp.
    assert!(
        warnings(&scene(&disk(5.5, "\"float radius\" 1"), &[&disk(5.5, "\"float radius\" 3 \"float innerradius\" 1")]))
            .is_empty()
    );
}

#[test]
fn meshes_of_many_triangles_instances_and_other_lamps_are_found_too() {
    let lamp = quad([-1.0, 1.0], 5.5, [-1.0, 1.0]);
    assert_eq!(warnings(&scene(&lamp, &[&grid(150, 5.5, |_, _| false)])).len(), 1);
    // A lamp of many triangles, of which one part lies in the ceiling.
    let many = grid(60, 5.5, |_, _| false);
    assert_eq!(warnings(&scene(&many, &[&quad([-50.0, 50.0], 5.5, [-50.0, 50.0])])).len(), 1);
    let object = format!("ObjectBegin \"c\" {} ObjectEnd Translate 0 1.5 0", quad([-10.0, 10.0], 4.0, [-10.0, 10.0]));
    assert_eq!(warnings(&scene(&lamp, &[&object, "ObjectInstance \"c\""])).len(), 1);
    // Two lamps are named once; far from the origin as near it; one in another of the same size.
    let two = format!("AttributeBegin AreaLightSource \"diffuse\" {} AttributeEnd", quad([0.5, 2.0], 5.5, [0.0, 2.0]));
    assert_eq!(warnings(&scene(&lamp, &[&two])).len(), 1);
    let far =
        scene(&lamp, &[&quad([-10.0, 10.0], 5.5, [-10.0, 10.0])]).replace("WorldBegin", "WorldBegin Translate 1e6 -3e5 2e6");
    assert_eq!(warnings(&far).len(), 1);
    assert_eq!(warnings(&scene("Shape \"sphere\" \"float radius\" 2", &["Shape \"sphere\" \"float radius\" 2"])).len(), 1);
    assert!(warnings(&scene("Shape \"sphere\" \"float radius\" 2", &["Shape \"sphere\" \"float radius\" 2.001"])).is_empty());
    assert_eq!(warnings(&scene("Shape \"cylinder\"", &["Shape \"cylinder\" \"float zmax\" 0.2"])).len(), 1);
    // No more than ten are told.
    let ceilings: Vec<String> = (0..30).map(|i| quad([-10.0, 10.0 + f64::from(i)], 5.5, [-10.0, 10.0])).collect();
    let ceilings: Vec<&str> = ceilings.iter().map(String::as_str).collect();
    assert_eq!(warnings(&scene(&lamp, &ceilings)).len(), 10);
}

#[test]
fn a_little_below_the_ceiling_all_transports_agree() {
    // What the warning advises.
    let floor = |transport: &str| {
        let options = format!(
            r#"Film "rgb" "integer xresolution" 4 "integer yresolution" 4
            Sampler "independent" "integer pixelsamples" 2000
            LightTransport "{transport}" "integer maxdepth" 1
            LookAt 0 1 0  0 0 0  0 0 1  Camera "perspective" "float fov" 10
            "#
        );
        let [floor, ceiling] = [0.0, 2.5].map(|y| quad([-5.0, 5.0], y, [-5.0, 5.0]));
        let text = options + &scene(&quad([-1.0, 1.0], 2.499, [-1.0, 1.0]), &[&floor, &ceiling]);
        assert!(warnings(&text).is_empty());
        let built = lang::load_text("test.bhs", &text, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
        let Ok(built) = built else { panic!("{text}") };
        let data = bhs::render::render_quietly(&built).frame.picture().data;
        data.iter().map(|v| f64::from(*v)).sum::<f64>() / data.len() as f64
    };
    let (path, hemisphere) = (floor("path"), floor("hemisphere"));
    assert!((path / hemisphere - 1.0).abs() < 0.03, "{path} {hemisphere}");
}
