//! Reads the buffers of a glTF file, and the numbers that its accessors describe.

use super::context::{FileContext, ReadResult};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Source, View};
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;

/// Buffers of a glTF file. Each buffer is read when it is first needed.
pub(super) struct GltfBuffers<'a> {
    context: &'a FileContext<'a>,
    /// Binary chunk of a `.glb` file, until the first read of the buffer that this chunk holds.
    /// This read moves the bytes to `buffers`. `None` afterwards, or if the file has no binary
    /// chunk.
    blob: RefCell<Option<Vec<u8>>>,
    /// Bytes of the file's buffers, by buffer index. The cell of a buffer is empty until that
    /// buffer is read.
    buffers: Vec<OnceCell<Rc<[u8]>>>,
}

/// Decoded numbers of an accessor: a list of elements, such as scalars or vectors.
pub(super) struct AccessorValues {
    /// Number of components per element: 1 for scalars, 3 for three-dimensional vectors.
    pub components_per_element: usize,
    /// Components of all elements, one element after the other.
    ///
    /// Numbers that the file stores as normalized integers are already decoded to \[−1, 1].
    pub numbers: Vec<f64>,
}

impl AccessorValues {
    /// Returns the elements as arrays of `N` components.
    ///
    /// Fails with an error at `place` if elements have another number of components, or if a
    /// component is not finite.
    pub fn vector_elements<const N: usize>(&self, context: &FileContext<'_>, place: &str) -> ReadResult<Vec<[f64; N]>> {
        if self.components_per_element != N {
            return Err(context
                .error(place, format!("its elements have {} components instead of {N}", self.components_per_element)));
        }
        if let Some(i) = self.numbers.iter().position(|number| !number.is_finite()) {
            return Err(context.error(place, format!("element {} is not finite", i / N)));
        }
        Ok(self.numbers.as_chunks().0.to_vec())
    }
}

impl<'a> GltfBuffers<'a> {
    /// Returns the buffers of a file with `count` buffers; reads none yet.
    ///
    /// `blob` is the binary chunk of a `.glb` file; `None` if the file has none.
    pub fn new(context: &'a FileContext<'a>, count: usize, blob: Option<Vec<u8>>) -> Self {
        Self { context, blob: RefCell::new(blob), buffers: vec![OnceCell::new(); count] }
    }

    /// Returns a copy of the bytes of a buffer view.
    pub fn view_bytes(&self, view: &View<'_>) -> ReadResult<Box<[u8]>> {
        let buffer = self.buffer_bytes(view)?;
        let (start, length) = (view.offset(), view.length());
        match start.checked_add(length).and_then(|end| buffer.get(start..end)) {
            Some(bytes) => {
                self.context.check_memory(length as u64)?;
                Ok(bytes.into())
            }
            None => Err(self.buffer_too_short_error(view, buffer.len())),
        }
    }

    /// Returns all bytes of the buffer that contains `view`. Reads the buffer at its first use.
    fn buffer_bytes(&self, view: &View<'_>) -> ReadResult<Rc<[u8]>> {
        let buffer = view.buffer();
        let cell = &self.buffers[buffer.index()];
        if let Some(bytes) = cell.get() {
            return Ok(Rc::clone(bytes));
        }
        let place = format!("buffers[{}]", buffer.index());
        let bytes =
            match buffer.source() {
                Source::Bin => self.blob.borrow_mut().take().ok_or_else(|| {
                    self.context.error(&place, "it has no URI, and the file has no binary chunk for it")
                })?,
                Source::Uri(uri) => self.context.read_uri(&place, uri)?,
            };
        if bytes.len() < buffer.length() {
            let message = format!("it has {} bytes instead of {}", bytes.len(), buffer.length());
            return Err(self.context.error(&place, message));
        }
        Ok(Rc::clone(cell.get_or_init(|| bytes.into())))
    }

    fn buffer_too_short_error(&self, view: &View<'_>, length: usize) -> crate::format::SceneReadError {
        let message = format!("it ends beyond its buffer, which has {length} bytes");
        self.context.error(format!("bufferViews[{}]", view.index()), message)
    }

    /// Returns the numbers of an accessor.
    ///
    /// Accepts all component types, normalized integers, strides and sparse accessors. An accessor
    /// without a buffer view has elements of 0, except where its sparse part replaces them.
    pub fn read_accessor(&self, accessor: &Accessor<'_>) -> ReadResult<AccessorValues> {
        let place = format!("accessors[{}]", accessor.index());
        let width = components_per_element(accessor.dimensions());
        let count = accessor.count();
        let total = count.checked_mul(width).filter(|total| *total < usize::MAX / 16);
        let Some(total) = total else {
            return Err(self.context.error(&place, format!("{count} elements are too many")));
        };
        let is_normalized = accessor.normalized();
        let mut numbers = match accessor.view() {
            Some(view) => {
                let layout = AccessorLayout {
                    element_count: count,
                    components_per_element: width,
                    kind: accessor.data_type(),
                    is_normalized,
                };
                self.read_elements(&place, &view, accessor.offset(), layout)?
            }
            None => {
                self.context.check_memory(8 * total as u64)?;
                vec![0.0; total]
            }
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let layout =
                AccessorLayout { element_count: sparse.count(), components_per_element: 1, kind, is_normalized: false };
            let targets = self.read_elements(&place, &indices.view(), indices.offset(), layout)?;
            let layout = AccessorLayout {
                element_count: sparse.count(),
                components_per_element: width,
                kind: accessor.data_type(),
                is_normalized,
            };
            let replaced = self.read_elements(&place, &values.view(), values.offset(), layout)?;
            for (target, value) in targets.iter().zip(replaced.chunks_exact(width)) {
                let at = *target as usize * width;
                let Some(element) = numbers.get_mut(at..at + width) else {
                    return Err(self.context.error(&place, format!("its sparse index {target} is out of range")));
                };
                element.copy_from_slice(value);
            }
        }
        Ok(AccessorValues { components_per_element: width, numbers })
    }

    /// Returns the vertex indices that an accessor describes.
    pub fn read_indices(&self, accessor: &Accessor<'_>) -> ReadResult<Vec<u32>> {
        let is_unsigned = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !is_unsigned || accessor.normalized() || components_per_element(accessor.dimensions()) != 1 {
            let place = format!("accessors[{}]", accessor.index());
            return Err(self.context.error(place, "indices must be unsigned integers that are not normalized"));
        }
        Ok(self.read_accessor(accessor)?.numbers.iter().map(|index| *index as u32).collect())
    }

    /// Returns the components of all elements of an accessor, decoded from a buffer view.
    ///
    /// `offset` is the distance of the first element from the start of the view \[bytes]. `place`
    /// is the name of the accessor in error messages.
    fn read_elements(
        &self,
        place: &str,
        view: &View<'_>,
        offset: usize,
        layout: AccessorLayout,
    ) -> ReadResult<Vec<f64>> {
        let AccessorLayout { element_count: count, components_per_element: width, kind, is_normalized } = layout;
        let (component, element) = (kind.size(), kind.size() * width);
        let stride = view.stride().unwrap_or(element);
        let length = count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(element));
        let end = length.and_then(|length| offset.checked_add(length));
        if stride < element || (count > 0 && end.is_none_or(|end| end > view.length())) {
            let message = format!("{count} elements of {element} bytes do not fit into bufferViews[{}]", view.index());
            return Err(self.context.error(place, message));
        }
        let buffer = self.buffer_bytes(view)?;
        let bytes = view.offset().checked_add(view.length()).and_then(|end| buffer.get(view.offset()..end));
        let Some(bytes) = bytes else { return Err(self.buffer_too_short_error(view, buffer.len())) };
        self.context.check_memory(8 * (count * width) as u64)?;
        let mut numbers = Vec::with_capacity(count * width);
        for i in 0..count {
            for k in 0..width {
                let at = offset + i * stride + k * component;
                numbers.push(decoded_component(&bytes[at..at + component], kind, is_normalized));
            }
        }
        Ok(numbers)
    }
}

/// Number and format of the elements that an accessor stores in a buffer view.
#[derive(Clone, Copy)]
struct AccessorLayout {
    element_count: usize,
    components_per_element: usize,
    /// Type of each component, such as `F32`.
    kind: DataType,
    /// True if an integer component stands for a fraction: its value divided by the greatest value
    /// of its type.
    is_normalized: bool,
}

/// Returns the number of components per element, such as 3 for `Vec3`.
///
/// Padding bytes between the columns of matrices are not counted: no accessor that the importer
/// reads holds matrices.
fn components_per_element(dimensions: Dimensions) -> usize {
    dimensions.multiplicity()
}

/// Decodes one component of type `kind` from its little-endian `bytes`.
///
/// Normalized integers of 8 or 16 bits become numbers in \[−1, 1]. Returns NaN if the number of
/// bytes does not fit `kind`.
fn decoded_component(bytes: &[u8], kind: DataType, is_normalized: bool) -> f64 {
    let scaled = |number: f64, greatest: f64| if is_normalized { (number / greatest).max(-1.0) } else { number };
    match (kind, bytes) {
        (DataType::I8, &[a]) => scaled(f64::from(a as i8), 127.0),
        (DataType::U8, &[a]) => scaled(f64::from(a), 255.0),
        (DataType::I16, &[a, b]) => scaled(f64::from(i16::from_le_bytes([a, b])), 32_767.0),
        (DataType::U16, &[a, b]) => scaled(f64::from(u16::from_le_bytes([a, b])), 65_535.0),
        (DataType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_normalized_on_request() {
        assert_eq!(decoded_component(&[255], DataType::U8, true), 1.0);
        assert_eq!(decoded_component(&[0x80], DataType::I8, true), -1.0);
        assert_eq!(decoded_component(&[0x81], DataType::I8, true), -1.0);
        assert_eq!(decoded_component(&[0xff, 0x7f], DataType::I16, true), 1.0);
        assert_eq!(decoded_component(&[1, 2], DataType::U16, false), 513.0);
        assert_eq!(decoded_component(&1.5f32.to_le_bytes(), DataType::F32, true), 1.5);
    }
}
