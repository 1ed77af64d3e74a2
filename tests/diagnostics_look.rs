//! The look of what is said of a scene, to the letter.

use crate::diagnostics::{FOLDER, findings};
use bhs::lang::Overrides;
use bhs::report;
use expect_test::{Expect, expect};

fn rendering(scene: &str, overrides: &Overrides, expected: &Expect) {
    let (found, sources) = findings(&format!("{FOLDER}/{scene}.bhs"), overrides);
    expected.assert_eq(&report::render(&found, &sources, false));
}

#[test]
fn the_look_of_a_misspelt_parameter() {
    rendering(
        "unknown_parameter",
        &Overrides::default(),
        &expect![[r#"
            error: unknown parameter `stepp`
             --> tests/diagnostics/unknown_parameter.bhs:3:39
              |
            3 | Integrator "schwarzschild-rk4" "float stepp" 0.1
              |                                       ^^^^^ `schwarzschild-rk4` has no such parameter
              |
              = help: did you mean `step`?

            error: unknown parameter `yres`
             --> tests/diagnostics/unknown_parameter.bhs:7:14
              |
            7 |     "integer yres" 64
              |              ^^^^ `rgb` has no such parameter
              |
              = help: bhs calls it `yresolution`

            error: unknown parameter `centre`
              --> tests/diagnostics/unknown_parameter.bhs:12:50
               |
            12 | BlackHole "schwarzschild" "float rs" 0.1 "point3 centre" [0 1 5]
               |                                                  ^^^^^^ `schwarzschild` has no such parameter
               |
               = help: did you mean `center`?

            error: unknown parameter `reflectence`
              --> tests/diagnostics/unknown_parameter.bhs:15:25
               |
            15 | Material "diffuse" "rgb reflectence" [0.5 0.5 0.5]
               |                         ^^^^^^^^^^^ `diffuse` has no such parameter
               |
               = help: did you mean `reflectance`?

            error: unknown parameter `colour`
              --> tests/diagnostics/unknown_parameter.bhs:18:40
               |
            18 | Shape "sphere" "float radius" 1 "float colour" 3
               |                                        ^^^^^^ `sphere` has no such parameter
               |
               = help: `sphere` takes radius, zmin, zmax, phimax, motion

            5 errors
        "#]],
    );
}

#[test]
fn the_look_of_an_error_in_an_included_file() {
    rendering(
        "in_include",
        &Overrides::default(),
        &expect![[r#"
        error: this list is never closed
         --> tests/diagnostics/include/inner.bhs:3:31
          |
        3 | Shape "sphere" "float radius" [1
          |                               ^ opened here
          |
          = help: add a `]`
          = note: included from tests/diagnostics/include/outer.bhs:1:9
          = note: included from tests/diagnostics/in_include.bhs:3:9

        error: unknown shape `spehre`
         --> tests/diagnostics/include/inner.bhs:6:7
          |
        6 | Shape "spehre"
          |       ^^^^^^^^
          |
          = help: did you mean `sphere`?
          = note: included from tests/diagnostics/include/outer.bhs:1:9
          = note: included from tests/diagnostics/in_include.bhs:3:9

        2 errors
    "#]],
    );
}

#[test]
fn the_look_of_two_places_and_a_flag() {
    let overrides = Overrides { integrator: Some("schwarzschild-rk5".into()), ..Default::default() };
    rendering(
        "two_holes",
        &overrides,
        &expect![[r#"
            error: the scene has a spacetime already
             --> tests/diagnostics/two_holes.bhs:7:1
              |
            3 | BlackHole "schwarzschild" "point3 center" [0 0 5] "float rs" 0.1
              | --------- first one
            ...
            7 | BlackHole "schwarzschild" "point3 center" [0 0 9] "float rs" 0.1
              | ^^^^^^^^^ second one
              |
              = help: remove one of the two; several holes are one spacetime: `majumdar-papapetrou`

            error: unknown integrator `schwarzschild-rk5`
             --> <command line>:1:14
              |
            1 | --integrator schwarzschild-rk5
              |              ^^^^^^^^^^^^^^^^^
              |
              = help: did you mean `schwarzschild-rk4`?

            2 errors
        "#]],
    );
}

#[test]
fn the_look_of_what_is_never_closed() {
    rendering(
        "unclosed_both",
        &Overrides::default(),
        &expect![[r#"
        error: this list is never closed
         --> tests/diagnostics/unclosed_both.bhs:4:37
          |
        4 | LightSource "infinite" "spectrum L" [400 1 700 2
          |                                     ^ opened here
          |
          = help: add a `]`

        error: this list is never closed
         --> tests/diagnostics/unclosed_both.bhs:7:33
          |
        7 | Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0
          |                                 ^ opened here
          |
          = help: add a `]`

        error: this text is never closed
          --> tests/diagnostics/unclosed_both.bhs:11:10
           |
        11 | Material "diffuse
           |          ^ opened here
           |
           = help: add a `"`; text ends on the line it starts on

        error: this list is never closed
          --> tests/diagnostics/unclosed_both.bhs:16:30
           |
        16 | Shape "sphere" "string name" ["a" "b
           |                              ^ opened here
           |
           = help: add a `]`

        error: this text is never closed
          --> tests/diagnostics/unclosed_both.bhs:16:35
           |
        16 | Shape "sphere" "string name" ["a" "b
           |                                   ^ opened here
           |
           = help: add a `"`; text ends on the line it starts on

        5 errors
    "#]],
    );
}

#[test]
fn the_look_of_a_warning() {
    rendering(
        "attribute_unused",
        &Overrides::default(),
        &expect![[r#"
        warning: `raduis` is never used
         --> tests/diagnostics/attribute_unused.bhs:5:43
          |
        5 | Attribute "shape" "float radius" 2 "float raduis" 2
          |                                           ^^^^^^ no shape that follows has this parameter
          |
          = help: `bhs plugins shape` lists the parameters

        warning: `roughness` is never used
         --> tests/diagnostics/attribute_unused.bhs:8:29
          |
        8 | Attribute "material" "float roughness" 0.5
          |                             ^^^^^^^^^ no material that follows has this parameter
          |
          = help: `bhs plugins material` lists the parameters

    "#]],
    );
}

#[test]
fn the_look_of_a_scene_without_a_world() {
    rendering(
        "no_world",
        &Overrides::default(),
        &expect![[r#"
        error: the scene `tests/diagnostics/no_world.bhs` has no `WorldBegin`
         |
         = help: options such as `Camera` and `Film` come first, then `WorldBegin`, then lights and shapes

        1 error
    "#]],
    );
}
