//! The description of a scene as written: plain data in double precision, with text positions for
//! errors. Names and files are not looked up yet.
//!
//! Lengths are in the scene's own unit, which is the metre if a light's power is in watts. Angles
//! are in degrees, colors in linear RGB. [`parse`](super::parse) checks all values; a description
//! built by hand is unchecked.

pub use super::aim::DirectionOrTarget;
pub use super::camera::{
    ApertureDescription, CameraDescription, FocusDescription, LensDescription, ProjectionDescription,
};
pub use super::language::curves::{CurveBasis, ProfileCurve};
pub use super::lights::*;
pub use super::materials::*;
pub use super::media::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, TransformedBoxDescription,
};
pub use super::mesh::MeshOptions;
pub use super::shapes::*;
pub use super::span::{Span, Spanned};
pub use super::textured_value::TexturedValue;
pub use super::textures::{
    PictureEncoding, SolidPatternDescription, TexcoordTransformDescription, TextureDescription, TextureKindDescription,
    WrapMode,
};
pub use super::transform_step::TransformStep;

use glam::DVec3;

/// A whole scene, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDescription {
    /// Camera of the picture.
    pub camera: Spanned<CameraDescription>,
    /// Radiance along rays that hit nothing, in W/(m² sr). It does not illuminate surfaces. In a
    /// scene with an environment light, such rays see this light instead.
    pub background: DVec3,
    /// Name of the medium outside all bodies; `None` for vacuum.
    pub ambient_medium: Option<Spanned<String>>,
    /// Lights, in the order of the file.
    pub lights: Vec<Spanned<LightDescription>>,
    /// Textures, in the order of the file.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Media, in the order of the file.
    pub media: Vec<Spanned<MediumDescription>>,
    /// Materials, in the order of the file. Entries [`GroupItem::MaterialIndex`] refer to them by
    /// their index from 0.
    pub materials: Vec<Spanned<MaterialDescription>>,
    /// Top-level group: all objects of the scene, with the entries that set their materials.
    pub root: ObjectGroup,
}

/// A list of objects and of entries that set the objects' materials, in the order of the file.
///
/// In a parsed scene, groups and transforms nest at most
/// [`MAX_NESTING_DEPTH`](super::MAX_NESTING_DEPTH) deep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectGroup {
    /// Entries in the order of the file. A material applies to all objects that follow in the file,
    /// even beyond the end of its group.
    pub items: Vec<GroupItem>,
}

/// Entry of a group: an object, or the material of the objects that follow.
#[derive(Clone, Debug, PartialEq)]
pub enum GroupItem {
    /// Sets the material of the objects that follow in the file, by its index from 0.
    MaterialIndex(Spanned<u32>),
    /// Sets the material of the objects that follow in the file, by its name.
    MaterialName(Spanned<String>),
    /// An object or a nested group.
    Object(Spanned<ObjectDescription>),
}

/// An object of a description: a surface, a group, or a transformed or moving object.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectDescription {
    /// A nested group of objects.
    Group(ObjectGroup),
    /// An object under an affine transform.
    Transform {
        /// Steps of the transform from the object to its surroundings. The first listed step is
        /// applied last; only a matrix step is applied after all steps listed before it. See
        /// [`TransformStep::composed_matrix`].
        steps: Vec<TransformStep>,
        /// Object that the steps transform, in its own space.
        object: Box<Spanned<ObjectDescription>>,
    },
    /// An object that moves while the shutter is open.
    Moving {
        /// Steps of the motion: rotations, translations, and scales above 0, but no matrices.
        ///
        /// Each step grows from the identity, when the shutter opens, to its full size, when the
        /// shutter closes. The first listed step is applied last.
        steps: Vec<TransformStep>,
        /// Object that moves, in its own space.
        object: Box<Spanned<ObjectDescription>>,
    },
    /// A surface. It emits the radiance `emission`, or that of its material if `emission` is
    /// `None`.
    Shape {
        /// Geometry in object space.
        shape: ShapeDescription,
        /// Emitted radiance in W/(m² sr); `None` for the emission of the material.
        emission: Option<DVec3>,
    },
}
