//! The description of a scene, before any file is looked up: plain data in double precision, with
//! spans for errors.
//!
//! Lengths are in the scene's own unit (metres, if a light is given in watts), angles in degrees,
//! colors linear RGB. [`parse`](super::parse) checks all values; a description built by hand is
//! unchecked.

mod lights;
mod materials;
mod media;
mod textures;

use std::ops::Deref;

use glam::{DVec2, DVec3, DVec4};

pub use super::transform_step::TransformStep;
pub use lights::{
    AreaLightStrength, DirectionalLightStrength, EnvironmentRadiance, LightDescription, LightPattern,
    PointLightStrength,
};
pub use materials::{
    DielectricAbsorption, MaterialDescription, MaterialKindDescription, MetalDescription, RefractiveIndexDescription,
};
pub use media::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, TransformedBoxDescription,
};
pub use textures::{
    EmissionDescription, NormalPerturbationDescription, PictureEncoding, SolidPatternDescription,
    TexcoordTransformDescription, TextureDescription, TextureKindDescription, TexturedValue, Wrap,
};

/// A range of the scene's text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// Number of bytes.
    pub len: usize,
}

/// A value with the span of the text that it was read from. Equality ignores the span.
///
/// The span of a block (camera, light, material, object) is its keyword; the span of a name or
/// number is its own text.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its position in the text.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// `value`, read from `span`.
    pub const fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

impl<T: PartialEq> PartialEq for Spanned<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<T> Deref for Spanned<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// A whole scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDescription {
    /// The view to render.
    pub camera: Spanned<CameraDescription>,
    /// Radiance of rays that leave the scene.
    pub background: DVec3,
    /// Name of the medium that fills the space outside all bodies.
    pub ambient_medium: Option<Spanned<String>>,
    /// Lights, in the order of the file.
    pub lights: Vec<Spanned<LightDescription>>,
    /// Textures, in the order of the file.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Media, in the order of the file.
    pub media: Vec<Spanned<MediumDescription>>,
    /// Materials, in the order of the file; `MaterialIndex` counts them from 0.
    pub materials: Vec<Spanned<MaterialDescription>>,
    /// The objects.
    pub root: Group,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// The pinhole, the lens center, or the center of an orthographic picture.
    pub center: DVec3,
    /// Direction of view.
    pub aim: DirectionOrTarget,
    /// A direction that appears upward; not parallel to the view.
    pub up: DVec3,
    /// Projection.
    pub projection: ProjectionDescription,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Motion while the shutter is open, like that of [`ObjectDescription::Moving`], but about the
    /// camera's own position.
    pub motion: Vec<TransformStep>,
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProjectionDescription {
    /// Perspective through a pinhole or a thin lens.
    Perspective {
        /// Vertical field of view in degrees, inside (0, 180).
        angle: f64,
        /// Lens; `None` for a pinhole.
        lens: Option<LensDescription>,
    },
    /// Parallel projection.
    Orthographic {
        /// Height of the visible region, above 0.
        size: f64,
    },
    /// All directions, by longitude and latitude.
    Environment,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensDescription {
    /// Size of its opening.
    pub opening: ApertureDescription,
    /// Plane in focus.
    pub focus: FocusDescription,
    /// Number of blades of its diaphragm, at least 3; 0 for a round opening.
    pub blades: u32,
}

/// Size of a lens opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureDescription {
    /// Lens radius, at least 0.
    Radius(f64),
    /// Focal length over diameter, with the sensor height that determines the focal length; both
    /// above 0.
    FNumber {
        /// The f-number.
        number: f64,
        /// Height of the sensor.
        sensor: f64,
    },
}

/// Plane in focus, perpendicular to the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusDescription {
    /// Distance from the lens, above 0.
    Distance(f64),
    /// A point of the plane, in front of the camera.
    Point(DVec3),
}

/// Direction of a camera or spotlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionOrTarget {
    /// Direction of any length above 0.
    Direction(DVec3),
    /// Point to look at.
    LookAt(DVec3),
}

/// A list of objects. As parsed, groups and transforms nest at most
/// [`MAX_NESTING_DEPTH`](super::MAX_NESTING_DEPTH) deep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Entries in the order of the file: a material holds for all objects after it, also past the
    /// end of the group.
    pub items: Vec<GroupItem>,
}

/// One entry of a group.
#[derive(Clone, Debug, PartialEq)]
pub enum GroupItem {
    /// Index of the material of the objects that follow, from 0.
    MaterialIndex(Spanned<u32>),
    /// Name of the material of the objects that follow.
    MaterialName(Spanned<String>),
    /// An object.
    Object(Spanned<ObjectDescription>),
}

/// An object of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectDescription {
    /// Several objects.
    Group(Group),
    /// A transformed object.
    Transform {
        /// Composed by [`TransformStep::composed_matrix`]: the first listed is applied last.
        maps: Vec<TransformStep>,
        /// The object.
        object: Box<Spanned<ObjectDescription>>,
    },
    /// An object that moves while the shutter is open.
    Moving {
        /// Composed as in a transform. Each grows from the identity, when the shutter opens, to the
        /// full map, when it closes. None is a matrix, and scales are above 0.
        maps: Vec<TransformStep>,
        /// The object.
        object: Box<Spanned<ObjectDescription>>,
    },
    /// A surface.
    Shape {
        /// Geometry.
        shape: ShapeDescription,
        /// Emitted radiance in W/(m² sr); `None` for that of its material.
        emission: Option<DVec3>,
    },
}

/// Geometry of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeDescription {
    /// All points at `radius` from `center`.
    Sphere {
        /// Center.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// All points x with normal · x = offset.
    Plane {
        /// Normal of any length, as given.
        normal: DVec3,
        /// Distance from the origin in units of the normal's length.
        offset: f64,
    },
    /// A flat disc.
    Disc {
        /// Center.
        center: DVec3,
        /// Normal of any length.
        normal: DVec3,
        /// Radius.
        radius: f64,
    },
    /// A parallelogram with normal `edge0 × edge1`.
    Rectangle {
        /// The corner where both edges start.
        corner: DVec3,
        /// From the corner to its first neighbour.
        edge0: DVec3,
        /// From the corner to its other neighbour.
        edge1: DVec3,
    },
    /// An axis-aligned box.
    Box {
        /// Corner with the lowest coordinates.
        min: DVec3,
        /// Opposite corner, above `min` in every coordinate.
        max: DVec3,
    },
    /// A cylinder.
    Cylinder {
        /// Centers of both ends, which differ.
        ends: [DVec3; 2],
        /// Radius, above 0.
        radius: f64,
        /// True if discs close both ends.
        is_capped: bool,
    },
    /// A cone or truncated cone.
    Cone {
        /// Centers of both ends, which differ.
        ends: [DVec3; 2],
        /// Radii of both ends: the first above 0, the second at least 0.
        radii: [f64; 2],
        /// True if discs close both ends.
        is_capped: bool,
    },
    /// A triangle; its area may be 0.
    Triangle {
        /// Its corners.
        vertices: [DVec3; 3],
        /// Shading normals at the corners, of any length.
        normals: Option<[DVec3; 3]>,
        /// Texture coordinates at the corners; `None`: (0, 0), (1, 0), (0, 1).
        uv: Option<Box<[DVec2; 3]>>,
    },
    /// A mesh in a file of its own.
    Mesh {
        /// Path as written: not empty, no line breaks.
        path: Spanned<String>,
        /// Use of the file's materials and normals.
        options: MeshOptions,
    },
    /// The points (x cos θ, y, x sin θ) of a profile (x, y).
    Revolution {
        /// The curve that turns about the y axis.
        profile: ProfileCurve,
    },
    /// A curve by itself; it has no surface and is not visible.
    Curve(ProfileCurve),
    /// Bézier patches of equal degrees.
    Patches {
        /// Degrees along u and v, each from 1 to
        /// [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// (degree u + 1) · (degree v + 1) points with weights for each patch; the index
        /// along v varies fastest.
        controls: Vec<DVec4>,
    },
    /// A B-spline surface with weights.
    Nurbs {
        /// Degrees along u and v, each from 1 to
        /// [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// Number of control points along u and v, each above the degree.
        count: [u32; 2],
        /// Knots along u and v: count + degree + 1 nondecreasing numbers each; none for uniform
        /// knots.
        knots: [Vec<f64>; 2],
        /// Points with weights; the index along v varies fastest.
        controls: Vec<DVec4>,
    },
}

/// Use of a mesh file. The default is that of MIT 6.837.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// True if faces have the file's own materials instead of the scene's.
    pub uses_file_materials: bool,
    /// True if the file's normals are ignored.
    pub ignores_normals: bool,
    /// Greatest angle in degrees, inside [0, 180], between faces that are smoothed; `None` for flat
    /// faces. Applies to faces without normals.
    pub max_smoothing_angle: Option<f64>,
}

/// A polynomial curve.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileCurve {
    /// Basis of the control points.
    pub basis: CurveBasis,
    /// Control points: at least 2 for Bézier curves and 4 for B-splines.
    pub controls: Vec<DVec3>,
}

/// Basis of a curve's control points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveBasis {
    #[default]
    /// One Bézier curve of degree n − 1 for n control points.
    Bezier,
    /// A uniform cubic B-spline of n control points with knots i/(n + 3), unclamped.
    Bspline,
}
