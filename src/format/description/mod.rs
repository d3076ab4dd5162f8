//! The description of a scene as written: plain data in double precision, with text positions for
//! errors. Names and files are not looked up yet.
//!
//! Lengths are in the scene's own unit, which is the metre if a light's power is in watts. Angles
//! are in degrees, colors in linear RGB. [`parse`](super::parse) checks all values; a description
//! built by hand is unchecked.

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
    DielectricAbsorption, MAX_REFRACTIVE_INDEX, MIN_REFRACTIVE_INDEX, MaterialDescription, MaterialKindDescription,
    MetalDescription, RefractiveIndexDescription,
};
pub use media::{
    DensityDescription, MediumCoefficients, MediumDescription, PhaseFunctionDescription, TransformedBoxDescription,
};
pub use textures::{
    EmissionDescription, NormalPerturbationDescription, PictureEncoding, SolidPatternDescription,
    TexcoordTransformDescription, TextureDescription, TextureKindDescription, TexturedValue, WrapMode,
};

/// A range of bytes in the text of a scene, for error messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Offset of the first byte.
    pub start: usize,
    /// Length in bytes.
    pub len: usize,
}

/// A value with the span of the scene text that it was read from. Equality ignores the span.
///
/// A camera, light, material or object has the span of its keyword.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spanned<T> {
    /// The value that was read.
    pub value: T,
    /// Position in the scene's text.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// Creates a value with `span`, its position in the text.
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

/// A whole scene, as its file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDescription {
    /// Camera of the picture.
    pub camera: Spanned<CameraDescription>,
    /// Radiance of rays that leave the scene, in W/(m² sr).
    pub background: DVec3,
    /// Name of the medium outside all bodies; `None` for vacuum.
    pub ambient_medium: Option<Spanned<String>>,
    /// Lights, in the order of the file.
    pub lights: Vec<Spanned<LightDescription>>,
    /// Textures, in the order of the file.
    pub textures: Vec<Spanned<TextureDescription>>,
    /// Media, in the order of the file.
    pub media: Vec<Spanned<MediumDescription>>,
    /// Materials, in the order of the file; `MaterialIndex` counts them from 0.
    pub materials: Vec<Spanned<MaterialDescription>>,
    /// Top-level group: all objects of the scene, with the entries that set their materials.
    pub root: ObjectGroup,
}

/// A camera as the scene file describes it, with its picture size and motion.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// Position of the pinhole, of the lens center, or of the center of an orthographic picture.
    pub center: DVec3,
    /// View direction, or a point to look at.
    pub aim: DirectionOrTarget,
    /// Direction that appears upward in the picture; not parallel to the view.
    pub up: DVec3,
    /// Projection of the camera.
    pub projection: ProjectionDescription,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Steps of the motion while the shutter is open. The camera's own position is the origin of
    /// its rotations.
    ///
    /// The first listed step is applied last.
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
    /// Orthographic projection.
    Orthographic {
        /// Height of the visible region in scene units, above 0.
        size: f64,
    },
    /// Equirectangular projection of all directions.
    Environment,
}

/// A thin lens of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensDescription {
    /// Size of the aperture.
    pub aperture: ApertureDescription,
    /// Position of the plane in focus.
    pub focus: FocusDescription,
    /// Number of diaphragm blades, at least 3; 0 for a round aperture.
    pub blades: u32,
}

/// Size of a lens aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ApertureDescription {
    /// Lens radius, at least 0.
    Radius(f64),
    /// Given by the f-number: the ratio of focal length to lens diameter. The sensor height and the
    /// field of view give the focal length.
    FNumber {
        /// The f-number, above 0.
        number: f64,
        /// Height of the sensor in scene units, above 0.
        sensor: f64,
    },
}

/// Position of the plane in focus, which is perpendicular to the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusDescription {
    /// Distance of the plane in focus from the lens, above 0.
    Distance(f64),
    /// A point on the plane in focus, in front of the camera.
    Point(DVec3),
}

/// Orientation of a camera or light: a direction, or a point to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DirectionOrTarget {
    /// Direction of any length above 0.
    Direction(DVec3),
    /// Point that the camera or light looks at.
    LookAt(DVec3),
}

/// Objects in the order of the file, with the entries that set their materials.
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

/// An object of a description: a surface, a group, or a transformed object.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectDescription {
    /// A nested group of objects.
    Group(ObjectGroup),
    /// An object under an affine transform.
    Transform {
        /// Steps of the transform from the object to its surroundings. The first listed step is
        /// applied last.
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
    /// A surface that has its own emission or that of its material.
    Shape {
        /// Geometry in object space.
        shape: ShapeDescription,
        /// Emitted radiance in W/(m² sr); `None` for the emission of the material.
        emission: Option<DVec3>,
    },
}

/// Geometry of a surface, in object space.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeDescription {
    /// A sphere.
    Sphere {
        /// Center of the sphere.
        center: DVec3,
        /// Radius of the sphere, above 0.
        radius: f64,
    },
    /// The infinite plane of all points x with normal · x = offset.
    Plane {
        /// Normal of any length above 0.
        normal: DVec3,
        /// Distance of the plane from the origin, times the length of `normal`.
        offset: f64,
    },
    /// A flat disc.
    Disc {
        /// Center of the disc.
        center: DVec3,
        /// Normal of the disc, of any length above 0.
        normal: DVec3,
        /// Radius of the disc, above 0.
        radius: f64,
    },
    /// A parallelogram with normal `edge0 × edge1`.
    Rectangle {
        /// The corner where both edges start.
        corner: DVec3,
        /// Edge vector from the corner to one neighbor.
        edge0: DVec3,
        /// Edge vector from the corner to the other neighbor.
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
        /// Radius of the cylinder, above 0.
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
        /// Corners of the triangle.
        vertices: [DVec3; 3],
        /// Shading normals at the corners, of any length; `None` for the triangle's geometric
        /// normal.
        normals: Option<[DVec3; 3]>,
        /// Texture coordinates at the corners; `None` for (0, 0), (1, 0), (0, 1).
        uv: Option<Box<[DVec2; 3]>>,
    },
    /// A mesh in a file of its own.
    Mesh {
        /// Path of the mesh file as the text writes it: not empty, without line breaks.
        path: Spanned<String>,
        /// Choice of the triangles' materials and normals.
        options: MeshOptions,
    },
    /// Surface of revolution: the points (x cos θ, y, x sin θ) for all points (x, y) of a profile.
    Revolution {
        /// Profile curve, which rotates about the y axis.
        profile: ProfileCurve,
    },
    /// A curve without a surface, which is not visible.
    Curve(ProfileCurve),
    /// Rational Bézier patches that have the same degrees.
    Patches {
        /// Degrees along u and v, each from 1 to
        /// [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// Control points (x, y, z, weight): (degree u + 1) · (degree v + 1) for each patch. The
        /// index along v varies fastest.
        controls: Vec<DVec4>,
    },
    /// A rational B-spline surface (NURBS).
    Nurbs {
        /// Degrees along u and v, each from 1 to
        /// [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// Number of control points along u and v, each above the degree.
        count: [u32; 2],
        /// Knots along u and v: count + degree + 1 nondecreasing numbers each, or an empty list for
        /// uniform knots.
        knots: [Vec<f64>; 2],
        /// Control points (x, y, z, weight); the index along v varies fastest.
        controls: Vec<DVec4>,
    },
}

/// Options of a mesh shape: which materials and which normals its triangles get.
///
/// By default, triangles get the scene's current material and the file's normals. No smooth normals
/// are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// True if faces get the materials that the mesh file names; false if they get the scene's
    /// current material.
    pub uses_file_materials: bool,
    /// True if the file's normals are ignored.
    pub ignores_normals: bool,
    /// Largest angle between two neighboring faces that share smooth normals, in degrees, inside
    /// [0, 180].
    ///
    /// `None` computes no smooth normals, so such faces are flat. The angle applies only to faces
    /// without normals in the file.
    pub max_smoothing_angle: Option<f64>,
}

/// A polynomial curve in the xy plane, the profile of a surface of revolution.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileCurve {
    /// Polynomial basis to which `controls` belong.
    pub basis: CurveBasis,
    /// Control points: at least 2 for Bézier curves and 4 for B-splines.
    pub controls: Vec<DVec3>,
}

/// Polynomial basis of a profile curve, which defines its degree and its knots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveBasis {
    /// One Bézier curve of degree n − 1 for n control points.
    #[default]
    Bezier,
    /// A uniform, unclamped cubic B-spline of n control points with knots i/(n + 3).
    Bspline,
}
