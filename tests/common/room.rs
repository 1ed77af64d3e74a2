//! A room that takes a little of everything.

/// A room with a hole, a sphere and something glossy, lit from all sides, with more `lights`; `options` come before the camera.
pub fn room(options: &str, cameras: &str, lights: &str) -> String {
    format!(
        r#"
        {options}
        LookAt 0 1 -4  0 1 0  0 1 0
        {cameras}
        WorldBegin
        BlackHole "schwarzschild" "point3 center" [0 1.5 0] "float rs" 0.1
        LightSource "infinite" "rgb L" [0.7 0.8 1]
        {lights}
        Shape "sphere" "float radius" 0.6
        AttributeBegin
            Translate 1 1 1.5
            Material "conductor" "float roughness" 0.2
            Shape "sphere" "float radius" 0.6
        AttributeEnd
        Rotate -90 1 0 0
        Shape "disk" "float radius" 3
        "#
    )
}

/// What looks into it.
pub const CAMERA: &str = r#"Camera "perspective" "float fov" 45"#;
