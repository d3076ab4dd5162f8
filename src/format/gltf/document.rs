//! Parses and checks the container and the JSON of a glTF file.

use super::context::{FileContext, ReadResult};
use crate::format::import_notes::ImportNotes;
use gltf::json::validation::{Checked, Error as Defect, Validate};
use gltf::json::{Image, Path as JsonPath, Root};
use gltf::{Document, Semantic};
use serde_json::Value;

/// Estimated memory of each JSON object \[bytes]. It covers the object as a `serde_json` value, and
/// the record that the crate `gltf` makes of this value.
const MEMORY_PER_JSON_OBJECT: u64 = 1_200;

/// Estimated memory of each element of a JSON array and each member of a JSON object \[bytes].
const MEMORY_PER_JSON_VALUE: u64 = 100;

/// Estimated memory for each byte of the JSON text \[bytes]. Most of it is taken by strings.
const MEMORY_PER_BYTE: u64 = 4;

/// Extensions that the importer supports in addition to those of the crate `gltf`.
///
/// The importer refuses a file that requires an extension that is neither supported, by the crate
/// or by this list, nor ignored.
const EXTRA_SUPPORTED_EXTENSIONS: [&str; 9] = [
    "EXT_mesh_gpu_instancing",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_specular",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_basisu",
];

/// Material extensions that the importer ignores, each with the message that tells the user so.
///
/// A file may require these extensions, because ignoring them changes only details of a material.
pub(super) const IGNORED_MATERIAL_EXTENSIONS: [(&str, &str); 4] = [
    ("KHR_materials_anisotropy", "anisotropy is ignored: highlights are round"),
    ("KHR_materials_iridescence", "iridescence is ignored"),
    ("KHR_materials_sheen", "sheen is ignored"),
    ("KHR_materials_subsurface", "subsurface scattering is ignored"),
];

/// Extensions that do not change materials and that the importer ignores. A file may still list
/// them as required, because they only add animations or metadata.
const OTHER_IGNORED_EXTENSIONS: [&str; 2] = ["KHR_animation_pointer", "KHR_xmp_json_ld"];

/// Greatest number of defects that one error message describes.
const MAX_REPORTED_DEFECTS: usize = 3;

/// A parsed and validated glTF document, and the binary chunk of a `.glb` file.
pub(super) struct GltfFile {
    /// Content of the glTF JSON, already checked for defects.
    pub document: Document,
    /// Binary chunk of a `.glb` file, which holds its first buffer; `None` if the file has none.
    pub blob: Option<Vec<u8>>,
}

/// Parses and validates a `.gltf` or `.glb` file. The first bytes tell the two formats apart.
pub(super) fn parse_document(context: &FileContext<'_>, bytes: &[u8], notes: &mut ImportNotes) -> ReadResult<GltfFile> {
    let (json, blob) = if bytes.starts_with(b"glTF") { split_container(context, bytes)? } else { (bytes, None) };
    let count = |counted_byte: u8| json.iter().filter(|byte| **byte == counted_byte).count() as u64;
    context.check_memory(
        count(b'{') * MEMORY_PER_JSON_OBJECT
            + count(b',') * MEMORY_PER_JSON_VALUE
            + json.len() as u64 * MEMORY_PER_BYTE,
    )?;
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let mut value: Value = serde_json::from_slice(json).map_err(|e| context.error("JSON", e))?;
    take_required_extensions(context, &mut value, notes)?;
    adapt_json_to_parser(&mut value, notes);
    let root: Root = serde_json::from_value(value).map_err(|e| context.error("JSON", e))?;
    if !root.asset.version.starts_with("2.") {
        let help = "export it as glTF 2.0";
        return Err(context.error_with_help("asset", format!("glTF {} is not read", root.asset.version), help));
    }
    validate_document(context, &root)?;
    if let Some(i) = root.images.iter().position(|image| !has_image_source(image)) {
        return Err(context.error(format!("images[{i}]"), "it has no URI, and no buffer view with a MIME type"));
    }
    Ok(GltfFile { document: Document::from_json_without_validation(root), blob })
}

/// Returns the JSON text and the binary chunk of a `.glb` file.
///
/// The binary chunk is `None` if the file ends after the JSON, or if its second chunk is not of
/// type `BIN`.
fn split_container<'b>(context: &FileContext<'_>, bytes: &'b [u8]) -> ReadResult<(&'b [u8], Option<Vec<u8>>)> {
    let number = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let chunk = |at: usize| -> Option<(u32, &[u8])> {
        let (length, kind) = (number(at)? as usize, number(at + 4)?);
        Some((kind, bytes.get(at + 8..(at + 8).checked_add(length)?)?))
    };
    match number(4) {
        Some(2) => {}
        Some(version) => {
            let message = format!("version {version} of the container is not read");
            return Err(context.error_with_help("header", message, "export it as glTF 2.0"));
        }
        None => return Err(context.error("header", "the file ends in it")),
    }
    let Some((0x4e4f_534a, json)) = chunk(12) else {
        return Err(context.error("first chunk", "it is no JSON, or the file ends in it"));
    };
    let second = 12 + 8 + json.len().next_multiple_of(4);
    let blob = match chunk(second) {
        Some((0x004e_4942, binary)) => {
            context.check_memory(binary.len() as u64)?;
            Some(binary.to_vec())
        }
        Some(_) => None,
        None if bytes.len() <= second => None,
        None => return Err(context.error("second chunk", "the file ends in it")),
    };
    Ok((json, blob))
}

/// Removes the list `extensionsRequired` from the JSON, because the crate `gltf` would refuse some
/// extensions that this importer accepts.
///
/// Fails if the list contains an extension that the importer neither supports nor ignores. Adds a
/// note for each required extension that the importer ignores.
fn take_required_extensions(context: &FileContext<'_>, root: &mut Value, notes: &mut ImportNotes) -> ReadResult<()> {
    let Some(Value::Array(required)) = root.as_object_mut().and_then(|root| root.remove("extensionsRequired")) else {
        return Ok(());
    };
    for (i, extension) in required.iter().enumerate() {
        let name = extension.as_str().unwrap_or("?");
        let is_read =
            EXTRA_SUPPORTED_EXTENSIONS.contains(&name) || gltf::json::extensions::ENABLED_EXTENSIONS.contains(&name);
        let is_ignored = OTHER_IGNORED_EXTENSIONS.contains(&name)
            || IGNORED_MATERIAL_EXTENSIONS.iter().any(|(ignored, _)| *ignored == name);
        if is_ignored {
            notes.add_unsupported("required extensions are ignored", name);
        } else if !is_read {
            let message = format!("the required extension `{name}` is not read");
            let help = "export the file without this extension, for example without compression";
            return Err(context.error_with_help(format!("extensionsRequired[{i}]"), message, help));
        }
    }
    Ok(())
}

/// Changes the JSON so that the crate `gltf` accepts it.
///
/// Removes all animations, because the crate refuses some of them, and adds a note for each. A
/// scene without a list of nodes gets an empty list, because the crate demands one.
fn adapt_json_to_parser(root: &mut Value, notes: &mut ImportNotes) {
    let Some(root) = root.as_object_mut() else { return };
    if let Some(animations) = root.remove("animations") {
        for i in 0..animations.as_array().map_or(0, Vec::len) {
            notes.add_unsupported("animations are ignored: nodes have their rest pose", format!("animations[{i}]"));
        }
    }
    for scene in root.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
}

/// Fails if the document has defects, such as indices out of range.
///
/// The error describes the first [`MAX_REPORTED_DEFECTS`] defects, and counts the rest.
fn validate_document(context: &FileContext<'_>, root: &Root) -> ReadResult<()> {
    check_position_accessor_indices(context, root)?;
    let mut defects = Vec::new();
    let mut count = 0;
    root.validate(root, JsonPath::new, &mut |path: &dyn Fn() -> JsonPath, defect: Defect| {
        count += 1;
        if defects.len() < MAX_REPORTED_DEFECTS {
            defects.push((path(), defect));
        }
    });
    let Some((first, _)) = defects.first() else { return Ok(()) };
    let described = |(path, defect): &(JsonPath, Defect)| format!("{path} is {}", defect_text(*defect));
    let mut message = described(&defects[0]);
    for defect in &defects[1..] {
        message += &format!("; {}", described(defect));
    }
    if count > defects.len() {
        message += &format!("; and {} more", count - defects.len());
    }
    Err(context.error(first, message))
}

/// Fails if a primitive refers to an accessor of positions that does not exist.
///
/// Without this check, the validation by the crate `gltf` would panic.
fn check_position_accessor_indices(context: &FileContext<'_>, root: &Root) -> ReadResult<()> {
    for (i, mesh) in root.meshes.iter().enumerate() {
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if positions.is_some_and(|index| index.value() >= root.accessors.len()) {
                let place = format!("meshes[{i}].primitives[{k}].attributes.POSITION");
                return Err(context.error(place, "it is an index out of range"));
            }
        }
    }
    Ok(())
}

/// True if an image has a URI, or a buffer view with a MIME type.
///
/// The crate `gltf` would panic on any other image.
fn has_image_source(image: &Image) -> bool {
    if image.buffer_view.is_some() { image.mime_type.is_some() } else { image.uri.is_some() }
}

fn defect_text(defect: Defect) -> &'static str {
    match defect {
        Defect::IndexOutOfBounds => "an index out of range",
        Defect::Invalid => "an invalid value",
        Defect::Missing => "missing",
        Defect::Oversize => "too large",
        Defect::Unsupported => "not supported",
    }
}
