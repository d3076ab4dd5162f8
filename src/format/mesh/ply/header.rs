//! Parser of PLY headers, which declare the elements of the body and their properties.

use crate::format::line_error::{MessageAndRemedy, escaped_excerpt};

/// Encoding of the body of a PLY file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Number type of a PLY property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyNumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl PlyNumberType {
    fn from_type_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the size of a number of this type in binary files \[bytes].
    pub fn byte_size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// Purpose for which the mesh reader uses a PLY property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyPropertyRole {
    /// Component of a vertex's position, normal or texture coordinates. The number is the index of
    /// this component in the list x, y, z, nx, ny, nz, u, v.
    VertexComponent(usize),
    /// List of a face's vertex indices.
    VertexIndices,
    /// Unused property, which is skipped.
    Other,
}

/// Property of a PLY element: a number, or a list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PlyProperty {
    pub role: PlyPropertyRole,
    /// Integer type of the list's length; `None` if the property is a single number.
    pub list_length_type: Option<PlyNumberType>,
    /// Type of the single number, or of each number of the list.
    pub number_type: PlyNumberType,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlyElementKind {
    Vertex,
    Face,
    Other,
}

/// Declaration of a PLY element, such as `element vertex 8` and its properties.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlyElement {
    pub kind: PlyElementKind,
    pub name: String,
    /// Number of elements of this kind in the body.
    pub count: u64,
    pub properties: Vec<PlyProperty>,
    /// Line number of the declaration, from 1.
    line: usize,
}

/// Parsed and checked header of a PLY file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlyHeader {
    pub encoding: PlyEncoding,
    pub elements: Vec<PlyElement>,
    /// Number of bytes of the header, which is the offset of the body.
    pub byte_count: usize,
    /// Number of lines of the header.
    pub line_count: usize,
}

/// Error of a header line: the line number, from 1, with a message and a remedy.
pub(super) type HeaderError = (usize, MessageAndRemedy);

/// Remedy for files that violate the PLY format.
const EXPORT_ANEW: &str = "export it anew as PLY";

/// Names of vertex properties, each with its index for [`PlyPropertyRole::VertexComponent`].
const VERTEX_PROPERTY_SLOTS: [(&str, usize); 14] = [
    ("x", 0),
    ("y", 1),
    ("z", 2),
    ("nx", 3),
    ("ny", 4),
    ("nz", 5),
    ("s", 6),
    ("t", 7),
    ("u", 6),
    ("v", 7),
    ("texture_u", 6),
    ("texture_v", 7),
    ("texture_s", 6),
    ("texture_t", 7),
];

impl PlyHeader {
    pub fn parse(bytes: &[u8]) -> Result<Self, HeaderError> {
        let mut header = Self { encoding: PlyEncoding::Ascii, elements: Vec::new(), byte_count: 0, line_count: 0 };
        let mut encoding = None;
        loop {
            let rest = &bytes[header.byte_count..];
            let number = header.line_count + 1;
            let header_error = |message: String, remedy| Err((number, (message, remedy)));
            let Some(end) = rest.iter().position(|b| matches!(b, b'\n' | b'\r')) else {
                return header_error("the header ends without `end_header`".to_owned(), EXPORT_ANEW);
            };
            let line = String::from_utf8_lossy(&rest[..end]);
            header.byte_count += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
            header.line_count += 1;
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                _ if number == 1 && line.trim() != "ply" => {
                    return header_error("the first line is not `ply`".to_owned(), EXPORT_ANEW);
                }
                Some("format") => {
                    encoding = Some(match words.next() {
                        Some("ascii") => PlyEncoding::Ascii,
                        Some("binary_little_endian") => PlyEncoding::LittleEndian,
                        Some("binary_big_endian") => PlyEncoding::BigEndian,
                        other => {
                            let message = format!("unknown format `{}`", escaped_excerpt(other.unwrap_or_default()));
                            return header_error(
                                message,
                                "known are ascii, binary_little_endian and binary_big_endian",
                            );
                        }
                    });
                }
                Some("element") => {
                    let element = parse_ply_element(words, number).map_err(|e| (number, e))?;
                    if element.kind != PlyElementKind::Other && header.elements.iter().any(|e| e.kind == element.kind) {
                        return header_error(format!("`{}` is declared twice", element.name), EXPORT_ANEW);
                    }
                    header.elements.push(element);
                }
                Some("property") => match header.elements.last_mut() {
                    Some(element) => {
                        let property = parse_ply_property(words, element.kind).map_err(|e| (number, e))?;
                        element.properties.push(property);
                    }
                    None => return header_error("a property stands before any element".to_owned(), EXPORT_ANEW),
                },
                Some("end_header") => break,
                Some("ply" | "comment" | "obj_info") | None => {}
                Some(word) => {
                    return header_error(
                        format!("`{}` is no line of a PLY header", escaped_excerpt(word)),
                        EXPORT_ANEW,
                    );
                }
            }
        }
        let Some(encoding) = encoding else {
            return Err((header.line_count, ("the header names no format".to_owned(), EXPORT_ANEW)));
        };
        header.encoding = encoding;
        header.elements.iter().try_for_each(PlyElement::check_required_properties)?;
        header.check_counts_fit_file(bytes.len())?;
        Ok(header)
    }

    /// Fails if the declared element counts need more bytes than a file of `bytes` bytes holds.
    fn check_counts_fit_file(&self, bytes: usize) -> Result<(), HeaderError> {
        // White space after the last number of a text file is optional.
        let mut left = bytes - self.byte_count + usize::from(self.encoding == PlyEncoding::Ascii);
        for element in &self.elements {
            let least = element.min_element_bytes(self.encoding);
            let needed = usize::try_from(element.count).ok().and_then(|n| n.checked_mul(least));
            match needed.and_then(|needed| left.checked_sub(needed)) {
                Some(rest) => left = rest,
                None => {
                    let message = format!(
                        "{} times `{}` need {least} bytes each at least, and {left} bytes are left of the file",
                        element.count, element.name
                    );
                    return Err((element.line, (message, "the file is cut short, or the count is wrong")));
                }
            }
        }
        Ok(())
    }
}

impl PlyElement {
    /// Returns the smallest possible size of one element of this kind in the file \[bytes].
    pub fn min_element_bytes(&self, encoding: PlyEncoding) -> usize {
        let one = |p: &PlyProperty| {
            // A face has at least three corners.
            let items = if p.role == PlyPropertyRole::VertexIndices { 3 } else { 0 };
            match encoding {
                PlyEncoding::Ascii => 2 + 2 * items,
                _ => p.list_length_type.unwrap_or(p.number_type).byte_size() + items * p.number_type.byte_size(),
            }
        };
        self.properties.iter().map(one).sum()
    }

    pub fn has_vertex_component(&self, slot: usize) -> bool {
        self.properties.iter().any(|p| p.role == PlyPropertyRole::VertexComponent(slot))
    }

    fn check_required_properties(&self) -> Result<(), HeaderError> {
        let header_error = |message: &str, remedy| Err((self.line, (message.to_owned(), remedy)));
        let index_list_count = self.properties.iter().filter(|p| p.role == PlyPropertyRole::VertexIndices).count();
        match self.kind {
            PlyElementKind::Vertex if !(0..3).all(|slot| self.has_vertex_component(slot)) => {
                header_error("`vertex` lacks one of the properties x, y and z", "export it with positions")
            }
            PlyElementKind::Face => match index_list_count {
                0 => header_error("`face` has no list `vertex_indices`", "export it with the corners of its faces"),
                1 => Ok(()),
                _ => header_error("`face` has two lists of vertex indices", "export it with one of them"),
            },
            PlyElementKind::Vertex | PlyElementKind::Other => Ok(()),
        }
    }
}

fn parse_ply_element<'w>(
    mut words: impl Iterator<Item = &'w str>,
    line: usize,
) -> Result<PlyElement, MessageAndRemedy> {
    let (name, count) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let Ok(count) = count.parse::<u64>() else {
        return Err((format!("`{}` is no count of elements", escaped_excerpt(count)), "write `element name count`"));
    };
    let kind = match name {
        "vertex" => PlyElementKind::Vertex,
        "face" => PlyElementKind::Face,
        _ => PlyElementKind::Other,
    };
    Ok(PlyElement { kind, name: escaped_excerpt(name), count, properties: Vec::new(), line })
}

fn parse_ply_property<'w>(
    mut words: impl Iterator<Item = &'w str>,
    kind: PlyElementKind,
) -> Result<PlyProperty, MessageAndRemedy> {
    let mut next = || words.next().unwrap_or_default();
    let known = |name: &str| {
        let message = || format!("`{}` is no type of a number", escaped_excerpt(name));
        PlyNumberType::from_type_name(name)
            .ok_or_else(|| (message(), "known are char to uint, int8 to uint32, float and double"))
    };
    let first = next();
    let (list, item) = match first {
        "list" => (Some(known(next())?), known(next())?),
        name => (None, known(name)?),
    };
    let name = next();
    if list.is_some_and(|count| !count.is_integer()) {
        let message = format!("the length of the list `{}` is not a whole number", escaped_excerpt(name));
        return Err((message, "give it an integer type, such as uchar"));
    }
    let role = match (kind, name, list) {
        (PlyElementKind::Vertex, _, None) => VERTEX_PROPERTY_SLOTS
            .iter()
            .find(|(known, _)| *known == name)
            .map_or(PlyPropertyRole::Other, |(_, slot)| PlyPropertyRole::VertexComponent(*slot)),
        (PlyElementKind::Face, "vertex_indices" | "vertex_index", Some(_)) => {
            if !item.is_integer() {
                let message = format!("the indices `{name}` are not whole numbers");
                return Err((message, "give them an integer type, such as int"));
            }
            PlyPropertyRole::VertexIndices
        }
        _ => PlyPropertyRole::Other,
    };
    Ok(PlyProperty { role, list_length_type: list, number_type: item })
}
