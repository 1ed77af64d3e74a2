//! What a file may be that is no mesh of the kind that was meant: for messages.

/// What the beginning of a file looks like, as the end of a sentence; empty if it looks like nothing that is known.
pub(crate) fn looks_like(start: &[u8]) -> &'static str {
    let text = String::from_utf8_lossy(&start[..start.len().min(512)]).to_lowercase();
    // Comments of OBJ files say nothing.
    let text = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or(&text);
    let begins = |words: &[&str]| words.iter().any(|word| text.starts_with(word));
    match start {
        _ if begins(&["<!doctype", "<html"]) => "; it is a web page: download the file itself, not the page that shows it",
        _ if begins(&["version https://git-lfs"]) => "; it is a pointer of Git LFS: fetch the file itself with `git lfs pull`",
        _ if text == "ply" && start.len() > 3 => "; it is a PLY file: Shape \"plymesh\" reads it",
        _ if begins(&["solid "]) => "; it looks like STL: Shape \"stlmesh\" reads it",
        _ if matches!(text, "off" | "coff" | "noff") => "; it looks like OFF: convert it to PLY or OBJ",
        _ if begins(&["{"]) => "; it looks like JSON, perhaps glTF, which Shape \"gltf\" reads",
        _ if begins(&["<?xml", "<scene", "<collada"]) => "; it looks like XML: convert it to glTF or OBJ",
        _ if begins(&["glb", "gltf"]) => "; it is glTF: Shape \"gltf\" reads it",
        _ if begins(&["blender"]) => "; it is a file of Blender: export it as glTF",
        _ if begins(&["kaydara fbx"]) => "; it is FBX: convert it to glTF or OBJ",
        [b'P', b'K', 3, 4, ..] => "; it is a ZIP archive: unpack it first",
        [0x1f, 0x8b, ..] => "; it is compressed by gzip: unpack it first",
        [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..] | [0x76, 0x2f, 0x31, 0x01, ..] => "; it is a picture",
        _ if begins(&["v ", "vn ", "vt ", "mtllib", "o ", "g "]) => "; it looks like OBJ: Shape \"objmesh\" reads it",
        _ if begins(&["worldbegin", "camera ", "lookat ", "shape ", "film ", "attributebegin"]) => {
            "; it looks like a scene: `Include` reads it"
        }
        _ if start.len() > 3 && start.iter().take(64).all(|b| matches!(b, b'\t' | b'\n' | b'\r' | 0x20..=0x7e)) => {
            "; it is text, and no mesh that is known"
        }
        _ => "",
    }
}
