//! Reads the XML of a Mitsuba scene file as a tree of objects, with its includes and parameters.

use super::color::{ColorValue, parse_numbers};
use super::files::{MitsubaSceneFiles, MitsubaSourceLocation, ReadResult};
use super::names::snake_case;
use super::transforms::{parse_transform, parse_vector};
use super::tree::{ChildObject, MitsubaObject, MitsubaValue, ObjectClass, ObjectTree};
use crate::format::SourceText;
use crate::format::description::Span;
use crate::format::import::SceneReadError;
use roxmltree::{Document, Node, ParsingOptions};
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Greatest nesting depth of XML elements. Deeper recursion could overflow the stack.
const MAX_ELEMENT_DEPTH: u32 = 64;

/// Greatest depth of nested includes.
const MAX_INCLUDE_DEPTH: usize = 16;

/// Greatest number of includes in a scene. A file that is included twice counts twice.
const MAX_INCLUDES: usize = 10_000;

/// Greatest length of an attribute after each `$name` is replaced by its value \[bytes].
const MAX_EXPANDED_ATTRIBUTE_BYTES: usize = 1 << 16;

/// Greatest total size of the scene file and its includes \[bytes]. A file that is included twice
/// counts twice.
const MAX_TOTAL_BYTES: u64 = 1 << 28;

/// Greatest number of XML elements in the scene file and its includes.
const MAX_ELEMENTS: u64 = 1 << 22;

/// Estimated memory of an XML element in the tree of objects \[bytes].
const MEMORY_PER_ELEMENT: u64 = 600;

/// Estimated memory that the XML parser takes per byte of an XML file \[bytes].
const MEMORY_PER_XML_BYTE: u64 = 24;

/// Reads the scene file, whose content is `bytes`, with its includes, as a tree of objects.
pub(super) fn read_tree(files: &MitsubaSceneFiles<'_>, bytes: Vec<u8>) -> ReadResult<ObjectTree> {
    let mut reader = TreeReader {
        files,
        parameters: HashMap::new(),
        by_id: HashMap::new(),
        aliases: Vec::new(),
        include_stack: Vec::new(),
        include_count: 0,
        total_bytes: 0,
        element_count: 0,
        has_version_zero: false,
    };
    let mut root = ObjectContents::default();
    reader.read_xml(files.path, bytes, None, &mut root)?;
    for (alias, id, place) in std::mem::take(&mut reader.aliases) {
        let Some(object) = reader.by_id.get(&id).cloned() else { return Err(unknown_reference_error(&place, &id)) };
        reader.by_id.insert(alias, object);
    }
    let place = MitsubaSourceLocation {
        source: SourceText::new(&files.path.display().to_string(), ""),
        span: Span::default(),
        line: 1,
    };
    let root = root.into_object(ObjectClass::Scene, "scene", None, place);
    Ok(ObjectTree { root: Rc::new(root), by_id: reader.by_id, has_version_zero: reader.has_version_zero })
}

/// Returns an error: the element at `place` refers to `id`, but no object has this identifier.
pub(super) fn unknown_reference_error(place: &MitsubaSourceLocation, id: &str) -> SceneReadError {
    place.error(format!("no object has the id `{id}`"), "correct the id, or define the object")
}

/// State of the reader of a scene file and the files that it includes.
struct TreeReader<'r, 'a> {
    files: &'r MitsubaSceneFiles<'a>,
    /// Values of parameters, to which attributes refer as `$name`. If a parameter is defined
    /// repeatedly, its first value stays.
    parameters: HashMap<String, String>,
    /// Objects by identifier.
    by_id: HashMap<String, Rc<MitsubaObject>>,
    /// Elements `alias`, which give an object a second identifier. Each entry holds the second
    /// identifier, the first one, and the position of the element.
    aliases: Vec<(String, String, MitsubaSourceLocation)>,
    /// Files that are being read, from the scene file to the innermost include.
    include_stack: Vec<PathBuf>,
    include_count: usize,
    total_bytes: u64,
    element_count: u64,
    /// True if the scene file, which is read first, states a version before 1.
    has_version_zero: bool,
}

/// Values and nested objects of one object, collected while the object is read.
#[derive(Default)]
struct ObjectContents {
    values: BTreeMap<String, (MitsubaValue, Cell<bool>)>,
    children: Vec<(String, ChildObject)>,
}

impl ObjectContents {
    fn into_object(
        self,
        class: ObjectClass,
        plugin: &str,
        id: Option<String>,
        place: MitsubaSourceLocation,
    ) -> MitsubaObject {
        let Self { values, children } = self;
        MitsubaObject { class, plugin: plugin.to_owned(), id, place, values, children, is_used: Cell::new(false) }
    }
}

/// Text of the file that is being read, with the position of the element that was read last.
struct CurrentFile {
    source: SourceText,
    /// Byte offset of the element that was read last, and its line, from 1.
    last_offset_and_line: Cell<(usize, u32)>,
}

impl CurrentFile {
    /// Returns the position of an element in the file.
    ///
    /// If the element follows the one that was read last, lines are counted from there, to save
    /// time. Otherwise they are counted from the start of the file.
    fn element_place(&self, node: &Node<'_, '_>) -> MitsubaSourceLocation {
        let range = node.range();
        let (offset, line) = self.last_offset_and_line.get();
        let text = self.source.scene_text().as_bytes();
        let newlines = |bytes: &[u8]| bytes.iter().filter(|byte| **byte == b'\n').count() as u32;
        let line = if range.start >= offset {
            line + newlines(&text[offset..range.start])
        } else {
            1 + newlines(&text[..range.start])
        };
        self.last_offset_and_line.set((range.start, line));
        let tag = node.tag_name().name().len() + 1;
        MitsubaSourceLocation { source: self.source.clone(), span: Span { start: range.start, len: tag }, line }
    }
}

impl TreeReader<'_, '_> {
    /// Parses the file at `path`, whose content is `bytes`.
    ///
    /// Adds the objects and values in the file to `contents`, the contents of the enclosing object.
    /// `includer` is the position of the `include` element; `None` for the scene file.
    fn read_xml(
        &mut self,
        path: &Path,
        bytes: Vec<u8>,
        includer: Option<&MitsubaSourceLocation>,
        contents: &mut ObjectContents,
    ) -> ReadResult<()> {
        let name = path.display().to_string();
        let whole_file =
            |text: &str| MitsubaSourceLocation { source: SourceText::new(&name, text), span: Span::default(), line: 1 };
        self.total_bytes += bytes.len() as u64;
        self.files.check_memory(path, MEMORY_PER_XML_BYTE * bytes.len() as u64)?;
        if self.total_bytes > MAX_TOTAL_BYTES {
            let place = includer.cloned().unwrap_or_else(|| whole_file(""));
            return Err(place.error("the scene file and its includes are longer than 256 MiB", "put meshes into files"));
        }
        let Ok(text) = String::from_utf8(bytes) else {
            return Err(whole_file("").error("the file is not UTF-8 text", "save it in the encoding UTF-8"));
        };
        let options = ParsingOptions { nodes_limit: 4 * MAX_ELEMENTS as u32, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&text, options).map_err(|error| {
            let place = MitsubaSourceLocation { span: span_of_error(&text, &error), ..whole_file(&text) };
            let message = error.to_string();
            place.error(
                format!("the XML is damaged: {}", message.split(" at ").next().unwrap_or_default()),
                "repair the file: each element needs its end, and a document type is not allowed",
            )
        })?;
        let file = CurrentFile { source: SourceText::new(&name, &text), last_offset_and_line: Cell::new((0, 1)) };
        let root = document.root_element();
        let place = file.element_place(&root);
        self.include_stack.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        if includer.is_none() {
            let version = root.attribute("version").unwrap_or_default();
            self.has_version_zero = version.trim().split('.').next() == Some("0");
        }
        if root.tag_name().name() == "scene" {
            for child in root.children().filter(Node::is_element) {
                self.read_element(&file, child, 1, contents)?;
            }
        } else if includer.is_some() {
            self.read_element(&file, root, 1, contents)?;
        } else {
            let message = format!("the root of a Mitsuba scene is `scene`, not `{}`", root.tag_name().name());
            return Err(place.error(message, "name the file of the scene; --format names the format of other files"));
        }
        self.include_stack.pop();
        Ok(())
    }

    /// Reads an XML element, and adds it to `contents`, the contents of the enclosing object.
    ///
    /// `depth` is the nesting depth of the element.
    fn read_element(
        &mut self,
        file: &CurrentFile,
        node: Node<'_, '_>,
        depth: u32,
        contents: &mut ObjectContents,
    ) -> ReadResult<()> {
        let place = file.element_place(&node);
        self.element_count += 1;
        self.files.check_total_memory(MEMORY_PER_ELEMENT * self.element_count)?;
        if self.element_count > MAX_ELEMENTS {
            return Err(place.error("the scene has more than four million elements", "put meshes into files"));
        }
        if depth > MAX_ELEMENT_DEPTH {
            return Err(
                place.error(format!("elements are nested deeper than {MAX_ELEMENT_DEPTH}"), "nest them less deep")
            );
        }
        let tag = node.tag_name().name().to_ascii_lowercase();
        let attribute = |name: &str| node.attribute(name);
        let name = snake_case(&self.with_expanded_parameters(attribute("name").unwrap_or_default(), &place)?);
        match tag.as_str() {
            "default" => {
                let value = self.with_expanded_parameters(required_attribute(&node, "value", &place)?, &place)?;
                let name = required_attribute(&node, "name", &place)?;
                self.parameters.entry(name.to_owned()).or_insert(value);
                return Ok(());
            }
            "path" => {
                let value = self.with_expanded_parameters(required_attribute(&node, "value", &place)?, &place)?;
                self.files.add_folder(&value);
                return Ok(());
            }
            "include" => return self.read_include(&node, &place, contents),
            "alias" => {
                let id = self.with_expanded_parameters(required_attribute(&node, "id", &place)?, &place)?;
                let alias = self.with_expanded_parameters(required_attribute(&node, "as", &place)?, &place)?;
                self.aliases.push((alias, id, place));
                return Ok(());
            }
            "ref" => {
                let id = self.with_expanded_parameters(required_attribute(&node, "id", &place)?, &place)?;
                contents.children.push((name, ChildObject::Reference(id, place)));
                return Ok(());
            }
            _ => {}
        }
        let class = ObjectClass::from_tag(&tag).filter(|class| {
            *class != ObjectClass::Scene && (*class != ObjectClass::Texture || attribute("type").is_some())
        });
        if let Some(class) = class {
            let plugin = self.with_expanded_parameters(attribute("type").unwrap_or_default(), &place)?;
            let id = attribute("id").map(|id| self.with_expanded_parameters(id, &place)).transpose()?;
            let mut nested = ObjectContents::default();
            for child in node.children().filter(Node::is_element) {
                self.read_element(file, child, depth + 1, &mut nested)?;
            }
            let object = Rc::new(nested.into_object(class, &plugin, id.clone(), place.clone()));
            if let Some(id) = id
                && self.by_id.insert(id.clone(), Rc::clone(&object)).is_some()
            {
                return Err(place.error(format!("two objects have the id `{id}`"), "give each object its own id"));
            }
            contents.children.push((name, ChildObject::Own(object)));
            return Ok(());
        }
        let value = self.parse_value(file, &tag, &node, &place)?;
        if name.is_empty() {
            return Err(place.error(format!("this `{tag}` has no name"), "write an attribute `name`"));
        }
        contents.values.insert(name, (value, Cell::new(false)));
        Ok(())
    }

    /// Reads the file that an `include` element names. Adds the objects and values in this file to
    /// `contents`, the contents of the enclosing object.
    fn read_include(
        &mut self,
        node: &Node<'_, '_>,
        place: &MitsubaSourceLocation,
        contents: &mut ObjectContents,
    ) -> ReadResult<()> {
        let name = self.with_expanded_parameters(required_attribute(node, "filename", place)?, place)?;
        let path = self.files.find_file(&name, place)?;
        let absolute = path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.include_stack.contains(&absolute) {
            return Err(place.error(format!("`{name}` includes itself"), "remove the include"));
        }
        if self.include_stack.len() > MAX_INCLUDE_DEPTH {
            let message = format!("includes are nested deeper than {MAX_INCLUDE_DEPTH}");
            return Err(place.error(message, "nest them less deep"));
        }
        self.include_count += 1;
        if self.include_count > MAX_INCLUDES {
            return Err(place.error(format!("the scene has more than {MAX_INCLUDES} includes"), "join files"));
        }
        let bytes = self.files.read_file(&path)?;
        self.read_xml(&path, bytes, Some(place), contents)
    }

    /// Parses an element that holds a value, such as `float` or `transform`. Fails for any other
    /// element.
    fn parse_value(
        &self,
        file: &CurrentFile,
        tag: &str,
        node: &Node<'_, '_>,
        place: &MitsubaSourceLocation,
    ) -> ReadResult<MitsubaValue> {
        let text = |name: &str| self.with_expanded_parameters(required_attribute(node, name, place)?, place);
        let invalid = |what: &str, text: &str| {
            let excerpt: String = text.chars().take(40).collect();
            place.error(format!("`{excerpt}` is not {what}"), "correct the attribute `value`")
        };
        Ok(match tag {
            "float" | "integer" => {
                let text = text("value")?;
                match parse_numbers(&text).as_deref() {
                    Some([number]) => MitsubaValue::Number(*number),
                    _ => return Err(invalid("a number", &text)),
                }
            }
            "boolean" => match &*text("value")?.trim().to_ascii_lowercase() {
                "true" => MitsubaValue::Boolean(true),
                "false" => MitsubaValue::Boolean(false),
                other => return Err(invalid("`true` or `false`", other)),
            },
            "string" => MitsubaValue::Text(text("value")?),
            "point" | "vector" => {
                MitsubaValue::Vector(parse_vector(self.expanded_attributes(node, place)?, 0.0, place)?)
            }
            "rgb" | "srgb" | "color" => {
                let text = text("value")?;
                let color = ColorValue::parse_rgb(&text, tag == "srgb");
                MitsubaValue::Color(color.ok_or_else(|| invalid("a color: three numbers or `#rrggbb`", &text))?)
            }
            "spectrum" => match node.attribute("filename") {
                Some(name) => {
                    MitsubaValue::Color(self.read_spectrum_file(&self.with_expanded_parameters(name, place)?, place)?)
                }
                None => {
                    let text = text("value")?;
                    let spectrum = ColorValue::parse_spectrum(&text);
                    MitsubaValue::Color(
                        spectrum.ok_or_else(|| invalid("a spectrum: a number, or pairs `400:0.5`", &text))?,
                    )
                }
            },
            "blackbody" => {
                let kelvin = text("temperature")?;
                let temperature: Option<f64> = kelvin.trim().trim_end_matches(['K', 'k']).trim().parse().ok();
                let scale = match node.attribute("scale") {
                    Some(scale) => self.with_expanded_parameters(scale, place)?.trim().parse().ok(),
                    None => Some(1.0),
                };
                match (temperature, scale) {
                    (Some(kelvin), Some(scale)) if kelvin > 0.0 && kelvin < 1e9 => {
                        MitsubaValue::Color(ColorValue::Blackbody(kelvin, scale))
                    }
                    _ => return Err(invalid("a temperature above 0 K", &kelvin)),
                }
            }
            "transform" | "animation" => {
                let steps = node.children().filter(Node::is_element);
                let steps = steps.map(|step| {
                    let place = file.element_place(&step);
                    let attributes = self.expanded_attributes(&step, &place)?;
                    Ok((step.tag_name().name().to_ascii_lowercase(), attributes, place))
                });
                if tag == "animation" {
                    return Err(place.error("animated transforms are not read", "write the transform of one moment"));
                }
                MitsubaValue::Transform(parse_transform(&steps.collect::<ReadResult<Vec<_>>>()?)?)
            }
            _ => {
                let help = "remove it, or look up its name in the documentation of Mitsuba";
                return Err(place.error(format!("the element `{tag}` is not known"), help));
            }
        })
    }

    /// Reads the file `name` of a `spectrum` element.
    fn read_spectrum_file(&self, name: &str, place: &MitsubaSourceLocation) -> ReadResult<ColorValue> {
        let path = self.files.find_file(name, place)?;
        let bytes = self.files.read_file(&path)?;
        let spectrum = std::str::from_utf8(&bytes).ok().and_then(ColorValue::parse_spectrum_file);
        spectrum.ok_or_else(|| {
            let message = format!("the file `{name}` is not a list of wavelengths and values");
            place.error(message, "write a wavelength in nanometres and a value per line, in ascending order")
        })
    }

    /// Returns the attributes of an element, with parameters replaced by their values.
    fn expanded_attributes(
        &self,
        node: &Node<'_, '_>,
        place: &MitsubaSourceLocation,
    ) -> ReadResult<HashMap<String, String>> {
        let expanded = |text: &str| self.with_expanded_parameters(text, place);
        node.attributes().map(|a| Ok((a.name().to_ascii_lowercase(), expanded(a.value())?))).collect()
    }

    /// Returns `text` with each parameter `$name` replaced by its value.
    ///
    /// If several parameter names match after a `$`, the longest one is used.
    fn with_expanded_parameters(&self, text: &str, place: &MitsubaSourceLocation) -> ReadResult<String> {
        if !text.contains('$') {
            return Ok(text.to_owned());
        }
        let mut parts = text.split('$');
        let mut expanded = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let longest = part.find(|c| !is_name(c)).unwrap_or(part.len());
            let Some(length) = (1..=longest).rev().find(|end| self.parameters.contains_key(&part[..*end])) else {
                let message = format!("the parameter `${}` has no value", &part[..longest]);
                return Err(place.error(message, "give it one: `<default name=\"…\" value=\"…\"/>`"));
            };
            expanded.push_str(&self.parameters[&part[..length]]);
            expanded.push_str(&part[length..]);
            if expanded.len() > MAX_EXPANDED_ATTRIBUTE_BYTES {
                return Err(place.error("the parameters of this attribute are too long", "use shorter values"));
            }
        }
        Ok(expanded)
    }
}

/// Returns the attribute `name` of an element. Fails if the element has no such attribute.
fn required_attribute<'n>(node: &Node<'n, '_>, name: &str, place: &MitsubaSourceLocation) -> ReadResult<&'n str> {
    node.attribute(name).ok_or_else(|| {
        let message = format!("this `{}` has no attribute `{name}`", node.tag_name().name());
        place.error(message, "add the attribute")
    })
}

/// Returns the position in `text` of an error that the XML parser reports, as a span of length 1.
fn span_of_error(text: &str, error: &roxmltree::Error) -> Span {
    let position = error.pos();
    let line = text.split_inclusive('\n').take(position.row.saturating_sub(1) as usize).map(str::len).sum::<usize>();
    let column = text[line..].chars().take(position.col.saturating_sub(1) as usize).map(char::len_utf8).sum::<usize>();
    Span { start: line + column, len: 1 }
}
