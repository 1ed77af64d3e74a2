//! MTL files: what is read of them, whatever program wrote them.

use bhs_shapes::mtl::{self, Map, Material};

fn read(file: &str) -> (Vec<Material>, Vec<String>) {
    let read = mtl::parse(file.as_bytes()).expect("it is text");
    (read.materials, read.notes)
}

/// The one material of a file without fault.
fn one(statements: &str) -> Material {
    let (mut materials, notes) = read(&format!("newmtl m\n{statements}\n"));
    assert!(notes.is_empty() && materials.len() == 1, "{notes:?}");
    materials.remove(0)
}

fn map(statements: &str, name: &str) -> Map {
    one(statements).maps.remove(name).unwrap_or_else(|| panic!("no {name}: {statements}"))
}

#[test]
fn statements_are_read_in_every_program_s_way() {
    // Blender, 3ds Max (with tabs and indentation), a byte order mark, CRLF, names with spaces, lines that go on.
    let files = [
        "# Blender\n\nnewmtl Red Paint\nNs 250.0\nKa 1 1 1\nKd 0.8 0.1 0.2\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.45\nd 0.5\nillum 2\n",
        "\u{feff}newmtl Red Paint\r\n\tNs 250.0\r\n\tNi 1.4500\r\n\td 0.5\r\n\tTr 0.9\r\n\tillum 2\r\n\tKd 0.8 0.1 0.2\r\n\tKs 0.5\r\n\tKe 0.0 0.0 0.0\r\n",
        "newmtl Red Paint\rNs 250\rNi 1.45\rTr 0.5\rillum 2\rKd 0.8 \\\r 0.1 0.2\rKs 0.5 0.5 0.5\rKe 0 0 0",
        "NEWMTL Red Paint\nns 250 \nNI 1.45\nd -halo 0.5\nILLUM 2\nkd .8 .1 .2\nKs 5e-1 0.5 0.5\nKe 0 0 0\n",
    ];
    for file in files {
        let (materials, notes) = read(file);
        assert!(notes.is_empty() && materials.len() == 1, "{notes:?} {file}");
        let m = &materials[0];
        assert_eq!(m.name, "Red Paint");
        assert_eq!([m.colours["Kd"], m.colours["Ks"], m.colours["Ke"]], [[0.8, 0.1, 0.2], [0.5; 3], [0.0; 3]]);
        assert_eq!(["Ns", "Ni", "d", "illum"].map(|n| m.numbers[n]), [250.0, 1.45, 0.5, 2.0], "{file}");
    }
    let m = one("Pr 0.3\nPm 1\nPc 0.5\nPcr 0.1\nPs 1\naniso 0.2\nTf 0.9 1 0.8");
    assert_eq!(["Pr", "Pm", "Pc", "Pcr"].map(|n| m.numbers[n]), [0.3, 1.0, 0.5, 0.1]);
    assert_eq!(m.colours["Tf"], [0.9, 1.0, 0.8]);
}

#[test]
fn pictures_have_options_and_any_name() {
    let (scale, offset) = ([1.0; 2], [0.0; 2]);
    let plain = Map { path: "a b.png".into(), scale, offset, clamp: false, channel: None, gain: 1.0, bump: 1.0 };
    assert_eq!(map("map_Kd a b.png", "map_Kd"), plain);
    assert_eq!(map("map_kd \"a b.png\"", "map_Kd"), plain);
    let placed = map("map_Kd -s 2 3 1 -o 0.5 -0.25 -blendu on -bm 1.5 -clamp on -mm 0 0.5 textures\\a b.png", "map_Kd");
    let expected = Map {
        path: "textures/a b.png".into(),
        scale: [2.0, 3.0],
        offset: [0.5, -0.25],
        clamp: true,
        gain: 0.5,
        bump: 1.5,
        ..plain.clone()
    };
    assert_eq!(placed, expected);
    // Fewer numbers than there may be; a name that begins with a digit is none.
    assert_eq!(map("map_Kd -s 2 wood.png", "map_Kd").scale, [2.0, 1.0]);
    assert_eq!(map("map_Kd -o 1 2 3dwood.png", "map_Kd").path, "3dwood.png");
    assert_eq!(map("map_d -imfchan m C:\\work\\leaf.tga", "map_d").channel, Some('m'));
    assert_eq!(map("map_opacity leaf.png", "map_d").path, "leaf.png");
    let m = one("map_Bump -bm 0.2 b.png\nnorm n.png\nmap_Ks s.png\nmap_Ka a.png\nmap_Pr r.png\nmap_Pm m.png\nmap_Ke e.png");
    assert_eq!(m.unread, ["map_Ks"]);
    assert_eq!((m.maps.len(), m.maps["map_Bump"].bump, m.maps["norm"].path.as_str()), (5, 0.2, "n.png"));
    assert_eq!(map("bump b.png", "map_Bump").path, map("map_Kn b.png", "norm").path);
}

#[test]
fn what_cannot_be_read_is_told_with_its_line_and_the_rest_is_read() {
    let file = "Kd 1 1 1\nnewmtl a\nKd 1 2\nKs spectral a.rfl\nNs x\nNi nan\nmap_Kd -s 1 1\nwhat 3\nKe 1 2 3\nnewmtl b\nd 0.5\n";
    let (materials, notes) = read(file);
    assert_eq!(materials[0].colours.get("Ke"), Some(&[1.0, 2.0, 3.0]));
    assert_eq!((materials.len(), materials[1].numbers["d"]), (2, 0.5));
    let expected = [
        "line 1: `Kd` stands before the first `newmtl`, and is not read",
        "line 3: `Kd` needs three numbers, and is not read",
        "line 4: `Ks spectral` is not read: write three numbers",
        "line 5: `Ns` needs a number, and is not read",
        "line 6: `Ni` needs a number, and is not read",
        "line 7: `map_Kd` names no file, and is not read",
        "line 8: `what` is not known, and not read",
    ];
    assert_eq!(notes, expected);
    let many = read(&format!("newmtl a\n{}", "x\n".repeat(100))).1;
    assert_eq!((many.len(), many[20].as_str()), (21, "80 more statements are not read"));
    assert!(mtl::parse(b"\xff\xfen\0").is_err_and(|e| e.contains("UTF-16")));
    assert!(read("").0.is_empty());
}
