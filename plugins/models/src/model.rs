//! A glTF file: its description, and the bytes that this speaks of.

use bhs_core::image::Image;
use data_url::DataUrl;
use gltf::Document;
use gltf::json::validation::{Error, Validate};
use std::sync::{Arc, OnceLock};

/// Reads a file that a model names, by its path as the model has it.
pub type ReadFile<'r> = &'r dyn Fn(&str) -> Result<Arc<Vec<u8>>, String>;

/// A glTF file.
#[derive(Debug)]
pub struct Model {
    /// Its description, whose indices all are within range.
    pub document: Document,
    buffers: Vec<Stored>,
    /// Its pictures, each decoded when it is first asked for.
    pub(crate) pictures: Vec<OnceLock<Result<Arc<Image>, String>>>,
    /// Bytes of the file itself.
    pub(crate) length: usize,
    /// Extensions without which the file says that it cannot be shown, and which are not known here.
    pub unknown_extensions: Vec<String>,
}

/// Where the bytes of a buffer are.
#[derive(Clone, Debug)]
enum Stored {
    Here(Arc<Vec<u8>>),
    /// In a file of this path.
    File(String),
    Nowhere(String),
}

/// Extensions that are read by what they make of a file, wherever else they are not known.
const READ_HERE: [&str; 6] = [
    "KHR_materials_clearcoat",
    "KHR_materials_specular",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
];

/// Extensions whose lack is told where it shows.
const TOLD: [&str; 2] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];

impl Model {
    /// Reads a file, JSON or binary.
    ///
    /// # Errors
    /// What is wrong with it, in words that can follow "cannot read `file`: ".
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (json, blob) = parts(bytes)?;
        let root = gltf::json::Root::from_slice(json).map_err(|e| format!("its JSON is no glTF 2.0: {e}"))?;
        if !root.asset.version.starts_with('2') {
            return Err(format!("it is of version {:?} of glTF; there is 2.0", shown(&root.asset.version)));
        }
        let mut unknown_extensions = Vec::new();
        // The check of the library takes it for granted that places are there.
        let mut attributes =
            root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|primitive| primitive.attributes.values());
        if let Some(index) = attributes.find(|index| index.value() >= root.accessors.len()) {
            return Err(format!(
                "it is damaged: a mesh names accessor {}, and there are {}",
                index.value(),
                root.accessors.len()
            ));
        }
        let mut first = None;
        root.validate(&root, gltf::json::Path::new, &mut |path, error| {
            // What says how far places reach is not needed, nor where numbers are that are compressed.
            let at = path().to_string();
            let is_dispensable = error == Error::Missing && [".min", ".max", ".bufferView"].iter().any(|end| at.ends_with(end));
            if error != Error::Unsupported && !is_dispensable {
                first.get_or_insert_with(|| format!("{at}: {error}"));
            }
        });
        if let Some(fault) = first {
            return Err(format!("it is damaged at {fault}"));
        }
        for name in &root.extensions_required {
            let known = gltf::json::extensions::ENABLED_EXTENSIONS.contains(&name.as_str());
            if !known && !READ_HERE.contains(&name.as_str()) && !TOLD.contains(&name.as_str()) {
                unknown_extensions.push(shown(name));
            }
        }
        let stored = |(i, buffer): (usize, &gltf::json::Buffer)| match &buffer.uri {
            None if i == 0 && blob.is_some() => Stored::Here(Arc::new(blob.unwrap_or_default().to_vec())),
            None => Stored::Nowhere("it names no file".to_owned()),
            Some(uri) => match data(uri) {
                None => Stored::File(decoded_path(uri)),
                Some(Ok(bytes)) => Stored::Here(Arc::new(bytes)),
                Some(Err(fault)) => Stored::Nowhere(fault),
            },
        };
        let buffers = root.buffers.iter().enumerate().map(stored).collect();
        let document = Document::from_json_without_validation(root);
        let pictures = document.images().map(|_| OnceLock::new()).collect();
        Ok(Self { document, buffers, pictures, length: bytes.len(), unknown_extensions })
    }

    /// The bytes of a buffer.
    ///
    /// # Errors
    /// That they are not there.
    pub fn buffer(&self, index: usize, read: ReadFile) -> Result<Arc<Vec<u8>>, String> {
        match self.buffers.get(index) {
            Some(Stored::Here(bytes)) => Ok(Arc::clone(bytes)),
            Some(Stored::File(path)) => read(path).map_err(|why| format!("cannot read its buffer `{path}`: {why}")),
            Some(Stored::Nowhere(why)) => Err(format!("its buffer {index} has no bytes: {why}")),
            None => Err(format!("it has no buffer {index}")),
        }
    }

    /// The bytes of a view into a buffer: the whole buffer, and the range.
    pub(crate) fn view(
        &self,
        view: &gltf::buffer::View,
        read: ReadFile,
    ) -> Result<(Arc<Vec<u8>>, std::ops::Range<usize>), String> {
        let bytes = self.buffer(view.buffer().index(), read)?;
        let end = view.offset().checked_add(view.length()).filter(|end| *end <= bytes.len());
        let Some(end) = end else {
            let (index, held) = (view.buffer().index(), bytes.len());
            return Err(format!("its buffer {index} ends before buffer view {} does: it holds {held} bytes", view.index()));
        };
        Ok((bytes, view.offset()..end))
    }
}

/// The JSON of a file, and the bytes behind it.
fn parts(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return match json.trim_ascii_start().first() {
            Some(b'{') => Ok((json, None)),
            _ => Err("it is neither glTF (JSON) nor GLB".to_owned()),
        };
    }
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    match (word(4), word(8)) {
        (Some(2), Some(length)) if length > bytes.len() => {
            return Err(format!("it is cut off: it says that it has {length} bytes, and has {}", bytes.len()));
        }
        (Some(2), Some(_)) => {}
        (Some(2), None) => return Err("it is cut off within its header".to_owned()),
        (Some(version), _) => return Err(format!("it is GLB of version {version}; there is 2")),
        (None, _) => return Err("it is cut off within its header".to_owned()),
    }
    let (mut at, mut json, mut blob) = (12, None, None);
    while let (Some(length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) {
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..length));
        let Some(chunk) = chunk else { return Err(format!("it is cut off within the chunk at byte {at}")) };
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if blob.is_none() => blob = Some(chunk),
            // Others are for programs that know them.
            _ => {}
        }
        at += 8 + length.next_multiple_of(4);
    }
    Ok((json.ok_or("it has no JSON")?, blob))
}

/// The bytes of a `data:` URI; `None` of any other.
pub(crate) fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    if !uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return None;
    }
    let decoded = DataUrl::process(uri).map_err(|_| "its `data:` URI is damaged".to_owned());
    Some(decoded.and_then(|url| url.decode_to_vec().map(|(bytes, _)| bytes).map_err(|_| "its base64 is damaged".to_owned())))
}

/// The path of a file that the file `path` names as `name`: relative ones start at its folder.
pub fn beside(path: &str, name: &str) -> String {
    match path.rfind('/') {
        Some(end) if !name.starts_with('/') => format!("{}/{name}", &path[..end]),
        _ => name.to_owned(),
    }
}

/// The path that a URI stands for.
pub(crate) fn decoded_path(uri: &str) -> String {
    percent_encoding::percent_decode_str(uri).decode_utf8_lossy().into_owned()
}

/// The beginning of a text, for a message.
pub(crate) fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(60).collect()
}
