//! Objects of an imported pbrt scene, and the object definitions (`ObjectBegin`) that instances
//! refer to.

use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::graphics_state::{MovingTransform, object_motion};
use crate::format::description::{
    GroupItem, ObjectDescription, ObjectGroup, ShapeDescription, Span, Spanned, TransformStep,
};
use crate::format::import_notes::ImportNotes;
use glam::{DAffine3, DMat4, DVec3};
use std::collections::HashMap;
use std::rc::Rc;

/// Greatest nesting depth of object instances in object definitions.
const MAX_INSTANCE_DEPTH: usize = 64;

/// Estimated memory of each object \[bytes], in the scene description and in the built scene
/// together.
pub(super) const MEMORY_PER_OBJECT: u64 = 2_000;

/// Objects of the imported scene, and the object definitions that instances copy.
#[derive(Default)]
pub(super) struct PbrtObjects {
    /// Objects of the imported scene with their materials, in the order of the file.
    root: ObjectGroup,
    /// Closed object definitions, by name.
    definitions: HashMap<String, Rc<ObjectDefinition>>,
    /// Name and content of the object definition between `ObjectBegin` and `ObjectEnd`; `None`
    /// outside of one.
    open_definition: Option<(String, ObjectDefinition)>,
}

/// Content of an object definition: the shapes between `ObjectBegin` and `ObjectEnd`.
#[derive(Clone, Default)]
struct ObjectDefinition {
    group: ObjectGroup,
    /// Number of shapes in the definition, including the shapes of nested instances.
    shape_count: u64,
    /// Nesting depth of instances: 0 if the definition contains no instances, 1 if it contains only
    /// instances of definitions of depth 0.
    instance_depth: usize,
}

/// Transforms of a shape or instance, and the position of its directive.
pub(super) struct PbrtPlacement<'a> {
    /// Map from pbrt's world to the imported scene: a reflection or the identity.
    pub mirror: DAffine3,
    /// Transform from object space to pbrt's world space, or to the space of the open object
    /// definition.
    pub transform: MovingTransform,
    /// Position of the directive in the file, for messages.
    pub place: &'a PbrtSourceLocation,
}

impl PbrtObjects {
    /// True between `ObjectBegin` and `ObjectEnd`.
    pub fn has_open_definition(&self) -> bool {
        self.open_definition.is_some()
    }

    /// Opens the definition of the object `name`. Later shapes and instances are added to it.
    pub fn begin_definition(&mut self, name: String) {
        self.open_definition = Some((name, ObjectDefinition::default()));
    }

    /// Closes the open definition; `None` if none is open.
    pub fn end_definition(&mut self) -> Option<()> {
        let (name, definition) = self.open_definition.take()?;
        self.definitions.insert(name, Rc::new(definition));
        Some(())
    }

    /// Adds `shapes` of one material to the open definition, or else to the scene.
    ///
    /// `emission` is the radiance that the shapes emit \[W/(m² sr)]; `None` if they emit nothing.
    pub fn add_shapes(
        &mut self,
        material: String,
        shapes: Vec<ShapeDescription>,
        emission: Option<DVec3>,
        placement: &PbrtPlacement<'_>,
        notes: &mut ImportNotes,
    ) {
        let (group, outer) = match &mut self.open_definition {
            Some((_, definition)) => {
                definition.shape_count += shapes.len() as u64;
                (&mut definition.group, DAffine3::IDENTITY)
            }
            None => (&mut self.root, placement.mirror),
        };
        group.items.push(GroupItem::MaterialName(Spanned::new(material, Span::default())));
        for shape in shapes {
            let object = Spanned::new(ObjectDescription::Shape { shape, emission }, Span::default());
            group.items.push(GroupItem::Object(transformed_object(object, outer, placement, notes)));
        }
    }

    /// Adds a copy of the object called `name` to the open definition, or else to the scene.
    pub fn add_instance(
        &mut self,
        name: &str,
        placement: &PbrtPlacement<'_>,
        files: &PbrtSceneFiles<'_>,
        notes: &mut ImportNotes,
    ) -> ReadResult<()> {
        let place = placement.place;
        let definition = self.definitions.get(name).cloned().ok_or_else(|| {
            place.error(format!("no object is called `{name}`"), "define it before: `ObjectBegin`, `ObjectEnd`")
        })?;
        files.reserve_memory(MEMORY_PER_OBJECT.saturating_mul(definition.shape_count))?;
        let object = Spanned::new(ObjectDescription::Group(definition.group.clone()), Span::default());
        let (group, outer) = match &mut self.open_definition {
            Some((_, open)) => {
                if definition.instance_depth + 1 > MAX_INSTANCE_DEPTH {
                    return Err(place.error("object instances nest too deep", "use fewer levels"));
                }
                open.shape_count += definition.shape_count;
                open.instance_depth = open.instance_depth.max(definition.instance_depth + 1);
                (&mut open.group, DAffine3::IDENTITY)
            }
            None => (&mut self.root, placement.mirror),
        };
        group.items.push(GroupItem::Object(transformed_object(object, outer, placement, notes)));
        Ok(())
    }

    /// Returns the objects of the scene.
    pub fn into_root(self) -> ObjectGroup {
        self.root
    }
}

/// Returns `object` with two transforms: first `placement.transform`, then `outer`.
///
/// `outer` is the mirror of the scene, or the identity inside an object definition, because the
/// definition's instances are mirrored as a whole. `placement.mirror` is not applied. The object
/// moves if its transforms at shutter opening and closing differ.
fn transformed_object(
    object: Spanned<ObjectDescription>,
    outer: DAffine3,
    placement: &PbrtPlacement<'_>,
    notes: &mut ImportNotes,
) -> Spanned<ObjectDescription> {
    let PbrtPlacement { transform, place, .. } = *placement;
    let with_transform = |map: DAffine3, object: Spanned<ObjectDescription>| {
        if map == DAffine3::IDENTITY {
            return object;
        }
        let steps = vec![TransformStep::Matrix(DMat4::from(map))];
        Spanned::new(ObjectDescription::Transform { steps, object: Box::new(object) }, Span::default())
    };
    let Some(motion) = object_motion(&transform) else { return with_transform(outer * transform.0[0], object) };
    if motion.omits_deformation {
        notes.add_unsupported("scales that change over the shutter stay as at its start", place.position_text());
    }
    let center = DAffine3::from_translation(motion.rotation_center);
    let object = with_transform(center.inverse() * transform.0[0], object);
    let moving = ObjectDescription::Moving { steps: motion.steps, object: Box::new(object) };
    with_transform(outer * center, Spanned::new(moving, Span::default()))
}
