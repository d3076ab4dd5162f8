//! What a scene file says, before anything is looked up: plain data in double precision, with places for errors.
//!
//! Lengths are in the scene's own unit (metres, where a light is given in watts), angles in degrees, colours linear RGB.
//! Values that come from [`parse`](super::parse) have passed its checks; values built by hand need not have.

mod lights;
mod materials;
mod media;
mod textures;

use std::ops::Deref;

use glam::{DVec2, DVec3, DVec4};

pub use super::map::Map;
pub use lights::{AreaStrength, DirectionalStrength, EnvironmentRadiance, Light, LightPattern, PointStrength};
pub use materials::{Attenuation, Material, MaterialKind, Metal, Refraction};
pub use media::{Coefficients, Density, Extent, Medium, Phase};
pub use textures::{Coordinates, Emission, Encoding, Pattern, Relief, Texture, TextureKind, Value, Wrap};

/// A stretch of the scene's text, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// Number of bytes.
    pub len: usize,
}

/// A value with the place that it was read from. Equality looks at the value alone.
///
/// The span of a block (camera, light, material, object) is its keyword; the span of a name or number is its own text.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spanned<T> {
    /// What was read.
    pub value: T,
    /// Where it stands in the text.
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
pub struct Description {
    /// The view to render.
    pub camera: Spanned<Camera>,
    /// Radiance of rays that leave the scene.
    pub background: DVec3,
    /// Name of the medium that is wherever no body is.
    pub filling: Option<Spanned<String>>,
    /// In the order of the file.
    pub lights: Vec<Spanned<Light>>,
    /// In the order of the file.
    pub textures: Vec<Spanned<Texture>>,
    /// In the order of the file.
    pub media: Vec<Spanned<Medium>>,
    /// In the order of the file, which `MaterialIndex` counts from 0.
    pub materials: Vec<Spanned<Material>>,
    /// The shapes.
    pub root: Group,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole, the middle of the lens, or the middle of an orthographic picture.
    pub center: DVec3,
    /// Where it looks.
    pub aim: Aim,
    /// A direction that appears upward; not parallel to the view.
    pub up: DVec3,
    /// How it sees.
    pub projection: Projection,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// How it turns and moves while the shutter is open, as of [`Object::Moving`], but as if its place were the origin.
    pub motion: Vec<Map>,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a pinhole or a lens.
    Perspective {
        /// Vertical field of view in degrees, inside (0, 180).
        angle: f64,
        /// `None`: a pinhole.
        lens: Option<Lens>,
    },
    /// In parallel.
    Orthographic {
        /// What the picture shows from top to bottom, above 0.
        size: f64,
    },
    /// All around, by longitude and latitude.
    Environment,
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// How wide it is open.
    pub opening: Opening,
    /// What is sharp.
    pub focus: Focus,
    /// Blades of its diaphragm, at least 3, or 0: round.
    pub blades: u32,
}

/// How wide a lens is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opening {
    /// Its radius, at least 0.
    Radius(f64),
    /// Focal length over diameter, and the height of the sensor from which the focal length follows; both above 0.
    FNumber {
        /// The f-number.
        number: f64,
        /// Height of the sensor.
        sensor: f64,
    },
}

/// What a lens makes sharp: the plane across the view ...
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// ... at a distance above 0.
    Distance(f64),
    /// ... through a point before the camera.
    Point(DVec3),
}

/// Where a camera or spotlight points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// Along a direction of any length.
    Direction(DVec3),
    /// Towards a point.
    LookAt(DVec3),
}

/// Objects side by side. As parsed, groups and transforms nest at most [`MAX_DEPTH`](super::MAX_DEPTH) deep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// In the order of the file, which matters: a material holds for all that follow, also past the group's end.
    pub items: Vec<Item>,
}

/// One entry of a group.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// What follows is made of this material, counted from 0.
    MaterialIndex(Spanned<u32>),
    /// What follows is made of the material of this name.
    MaterialName(Spanned<String>),
    /// Something to see.
    Object(Spanned<Object>),
}

/// Something to see.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    /// Objects side by side.
    Group(Group),
    /// An object that is moved, turned or stretched.
    Transform {
        /// Composed by [`Map::product`]: the first listed is applied last.
        maps: Vec<Map>,
        /// What is moved.
        object: Box<Spanned<Object>>,
    },
    /// An object that moves while the shutter is open.
    Moving {
        /// Composed as those of a transform. Each grows from nothing, where the shutter opens, to the whole of it, where it closes; none is a
        /// matrix, and scales are above 0.
        maps: Vec<Map>,
        /// What moves.
        object: Box<Spanned<Object>>,
    },
    /// A surface.
    Shape {
        /// Its form.
        shape: Shape,
        /// Radiance in W/(m² sr) instead of its material's.
        emission: Option<DVec3>,
    },
}

/// The form of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points at `radius` from `center`.
    Sphere {
        /// Its middle.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// All points x with normal · x = offset.
    Plane {
        /// Of any length, as given.
        normal: DVec3,
        /// Distance from the origin in units of the normal's length.
        offset: f64,
    },
    /// A flat disc.
    Disc {
        /// Its middle.
        center: DVec3,
        /// Of any length.
        normal: DVec3,
        /// Its radius.
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
        capped: bool,
    },
    /// A cone or truncated cone.
    Cone {
        /// Centers of both ends, which differ.
        ends: [DVec3; 2],
        /// Radii of both ends: the first above 0, the second at least 0.
        radii: [f64; 2],
        /// True if discs close both ends.
        capped: bool,
    },
    /// A triangle, of zero area too.
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
        /// As written: not empty, no line breaks.
        path: Spanned<String>,
        /// How the file is used.
        options: MeshOptions,
    },
    /// The points (x cos θ, y, x sin θ) of a profile (x, y).
    Revolution {
        /// The curve that turns about the y axis.
        profile: Curve,
    },
    /// A curve by itself, which has no surface.
    Curve(Curve),
    /// Bézier patches of the same degrees, one after the other.
    Patches {
        /// Along u and v, each from 1 to [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// Of each patch (degree u + 1) · (degree v + 1) points with weights, those along v one after the other.
        controls: Vec<DVec4>,
    },
    /// A B-spline surface with weights.
    Nurbs {
        /// Along u and v, each from 1 to [`MAX_DEGREE`](crate::shape::parametric::MAX_DEGREE).
        degree: [u32; 2],
        /// Number of control points along u and v, each above the degree.
        count: [u32; 2],
        /// Each count + degree + 1 numbers that do not decrease, or none: uniform.
        knots: [Vec<f64>; 2],
        /// Points with weights, those along v one after the other.
        controls: Vec<DVec4>,
    },
}

/// How the file of a mesh is used. By default as the course has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshOptions {
    /// Whether its faces are made of the file's own materials rather than of the scene's.
    pub own_materials: bool,
    /// Whether the file's normals are left out.
    pub no_normals: bool,
    /// The largest angle in degrees, inside [0, 180], between faces that are smoothed where normals are missing.
    pub smooth_angle: Option<f64>,
}

/// A polynomial curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What the control points mean.
    pub basis: CurveBasis,
    /// At least 2 for Bézier curves and 4 for B-splines.
    pub controls: Vec<DVec3>,
}

/// What the control points of a curve mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveBasis {
    #[default]
    /// One Bézier curve of degree n − 1 for n control points.
    Bezier,
    /// A uniform cubic B-spline of n control points with knots i/(n + 3), unclamped.
    Bspline,
}
