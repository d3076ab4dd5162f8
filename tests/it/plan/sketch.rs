//! Random scenes as lists of parts, which tests can inspect and write as scene text.

use crate::support::project_path;
use glam::{DMat3, DVec3};
use std::fmt::{self, Display, Write};
use std::fs;

/// A random scene as a list of its parts.
#[derive(Clone, Debug)]
pub struct Sketch {
    pub camera: String,
    pub background: DVec3,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    pub objects: Vec<Object>,
    /// The ambient medium, outside of all bodies.
    pub filling: Option<MediumSketch>,
    /// The part of the scene that moves, and its transforms as scene text.
    pub motion: Option<(Moving, String)>,
}

/// A part of the scene that can move; lights and objects are given by their index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moving {
    Camera,
    Light(usize),
    Object(usize),
}

#[derive(Clone, Debug)]
pub struct Light {
    pub kind: LightKind,
    /// Radiance, intensity, irradiance or power, depending on the kind of light.
    pub strength: DVec3,
}

#[derive(Clone, Debug)]
pub enum LightKind {
    Point(DVec3),
    Directional(DVec3),
    /// Spotlight: position, direction, full angle \[degrees], penumbra \[degrees].
    Spot(DVec3, DVec3, f64, f64),
    Sphere(DVec3, f64),
    /// Disc: center, normal, radius.
    Disc(DVec3, DVec3, f64),
    /// Rectangle: corner and edge vectors.
    Rectangle(DVec3, DVec3, DVec3),
    Environment,
}

/// Kind of medium, inside a body or around all bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MediumSketch {
    /// A medium that scatters light.
    Fog,
    /// A medium that absorbs light.
    Soot,
    /// A medium that emits light.
    Flame,
    /// A medium that has no effect.
    Nothing,
    /// A medium that scatters light, with a density grid.
    Puff,
}

impl MediumSketch {
    pub const ALL: [Self; 5] = [Self::Fog, Self::Soot, Self::Flame, Self::Nothing, Self::Puff];

    fn name(self) -> &'static str {
        match self {
            Self::Fog => "fog",
            Self::Soot => "soot",
            Self::Flame => "flame",
            Self::Nothing => "nothing",
            Self::Puff => "puff",
        }
    }

    pub fn scatters(self) -> bool {
        matches!(self, Self::Fog | Self::Puff)
    }
}

const MEDIA: &str = "Media {
    Medium fog { scattering .2 .3 .4  absorption .1 0 .05  anisotropy .5 }
    Medium soot { absorption .1 .2 .3 }
    Medium flame { absorption .2 .2 .2  emission 1 .5 .1 }
    Medium nothing { }
    Cloud puff { scattering 2 2 2  min -1 -1 -1  max 1 1 1  resolution 8 }
}
";

#[derive(Clone, Debug)]
pub enum Material {
    Diffuse(DVec3),
    /// Phong material: kd, ks, exponent.
    Phong(DVec3, DVec3, f64),
    Mirror(DVec3),
    /// Dielectric: index, absorption, roughness, priority.
    Dielectric(f64, DVec3, f64, u8),
    /// Metal of this roughness.
    Conductor(f64),
    Thin(f64),
    /// Mix of two earlier materials, given by their indices, and the fraction of the second.
    Mix(usize, usize, f64),
    /// Mix by a noise texture of two earlier materials; the second is where the noise is high.
    Mask(usize, usize),
    /// Diffuse material with a pattern of two colours.
    Patterned(DVec3, DVec3),
    /// Diffuse material of this colour, with a bump map of this height.
    Bumpy(DVec3, f64),
    /// Metal with a roughness texture between these values.
    RoughMap(f64, f64),
    /// Diffuse material that emits a pattern of two radiances.
    Panel(DVec3, DVec3),
    /// A null interface around a medium.
    Clear(MediumSketch),
    /// Dielectric of this index, filled with this medium.
    Filled(f64, MediumSketch),
    /// Dispersive glass of this name.
    Prism(&'static str),
}

#[derive(Clone, Debug)]
pub struct Object {
    pub material: usize,
    pub emission: DVec3,
    pub shape: Shape,
}

#[derive(Clone, Debug)]
pub enum Shape {
    Sphere(DVec3, f64),
    /// Ellipsoid: center, rotation about y \[degrees], half axes.
    Ellipsoid(DVec3, f64, DVec3),
    /// Disc: center, normal, radius.
    Disc(DVec3, DVec3, f64),
    /// Rectangle: corner and edge vectors.
    Rectangle(DVec3, DVec3, DVec3),
    /// Plane through this point, with this normal.
    Plane(DVec3, DVec3),
    Triangle([DVec3; 3]),
    /// Mesh file: path, center, rotation about y \[degrees], scale.
    Mesh(&'static str, DVec3, f64, f64),
}

/// Vector that is printed as three numbers of the scene language.
struct VectorText(DVec3);

impl Display for VectorText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.0.x, self.0.y, self.0.z)
    }
}

impl Sketch {
    /// Returns the scene as text of the scene language.
    pub fn text(&self) -> String {
        let wrapped = |what: Moving, text: String| match &self.motion {
            Some((moving, maps)) if *moving == what => format!("Moving {{ {maps}  {text} }}"),
            _ => text,
        };
        let camera = wrapped(Moving::Camera, format!("PerspectiveCamera {{ {} }}", self.camera));
        let filling = self.filling.map_or(String::new(), |stuff| format!("  medium {}", stuff.name()));
        let mut text = format!("{camera}\nBackground {{ color {}{filling} }}\n", VectorText(self.background));
        let mut write = |line: String| text.write_str(&line).unwrap();
        write("Lights {\n".into());
        let lights = self.lights.iter().enumerate();
        lights.for_each(|(i, light)| write(format!("    {}\n", wrapped(Moving::Light(i), light.to_string()))));
        write("}\nTextures {\n".into());
        self.materials.iter().enumerate().for_each(|(i, m)| write(m.texture(i)));
        write("}\n".into());
        let filled = |m: &Material| matches!(m, Material::Clear(_) | Material::Filled(..));
        if self.filling.is_some() || self.materials.iter().any(filled) {
            write(MEDIA.into());
        }
        write("Materials {\n".into());
        self.materials.iter().enumerate().for_each(|(i, m)| write(format!("    {}\n", m.named(i))));
        write("}\nGroup {\n".into());
        let objects = self.objects.iter().enumerate();
        objects.for_each(|(i, object)| {
            let placed = wrapped(Moving::Object(i), object.to_string());
            write(format!("    MaterialName m{}  {placed}\n", object.material));
        });
        write("}\n".into());
        text
    }

    /// Returns true if anything moves.
    pub fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Returns the media that some object or the scene contains.
    pub fn media(&self) -> Vec<MediumSketch> {
        let mut media: Vec<MediumSketch> = self.filling.into_iter().collect();
        for stuff in MediumSketch::ALL {
            let holds = |m: &Material| matches!(m, Material::Clear(s) | Material::Filled(_, s) if *s == stuff);
            if self.objects.iter().any(|o| self.is_of(o, &holds)) {
                media.push(stuff);
            }
        }
        media
    }

    /// Returns true if the predicate `is` holds for the material of `object`, or for a component of
    /// this material.
    pub fn is_of(&self, object: &Object, is: &dyn Fn(&Material) -> bool) -> bool {
        self.is_in(object.material, is)
    }

    /// Returns true if a material is a mask, or a mix that contains one.
    pub fn has_mask(&self, material: usize) -> bool {
        match &self.materials[material] {
            Material::Mix(first, second, _) => self.has_mask(*first) || self.has_mask(*second),
            Material::Mask(..) => true,
            _ => false,
        }
    }

    fn is_in(&self, material: usize, is: &dyn Fn(&Material) -> bool) -> bool {
        match &self.materials[material] {
            Material::Mix(first, second, _) | Material::Mask(first, second) => {
                self.is_in(*first, is) || self.is_in(*second, is)
            }
            other => is(other),
        }
    }
}

impl Display for Light {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = VectorText(self.strength);
        match &self.kind {
            LightKind::Point(p) => write!(f, "PointLight {{ position {}  intensity {s} }}", VectorText(*p)),
            LightKind::Directional(d) => {
                write!(f, "DirectionalLight {{ direction {}  irradiance {s} }}", VectorText(*d))
            }
            LightKind::Spot(p, d, angle, penumbra) => {
                let (p, d) = (VectorText(*p), VectorText(*d));
                write!(
                    f,
                    "SpotLight {{ position {p}  direction {d}  angle {angle}  penumbra {penumbra}  intensity {s} }}"
                )
            }
            LightKind::Sphere(c, r) => {
                write!(f, "SphereLight {{ center {}  radius {r}  radiance {s} }}", VectorText(*c))
            }
            LightKind::Disc(c, n, r) => {
                write!(
                    f,
                    "DiscLight {{ center {}  normal {}  radius {r}  radiance {s} }}",
                    VectorText(*c),
                    VectorText(*n)
                )
            }
            LightKind::Rectangle(c, a, b) => {
                write!(
                    f,
                    "RectangleLight {{ corner {}  edge0 {}  edge1 {}  radiance {s} }}",
                    VectorText(*c),
                    VectorText(*a),
                    VectorText(*b)
                )
            }
            LightKind::Environment => write!(f, "EnvironmentLight {{ radiance {s} }}"),
        }
    }
}

impl Material {
    /// Returns the scene text of the texture that material `i` uses; empty if it has none.
    fn texture(&self, i: usize) -> String {
        let noise = |a, b| {
            format!(
                "    Noise t{i} {{ color0 {}  color1 {}  frequency 3  amplitude 2 }}\n",
                VectorText(a),
                VectorText(b)
            )
        };
        match self {
            Self::Mask(..) | Self::Bumpy(..) => noise(DVec3::ZERO, DVec3::ONE),
            Self::Patterned(a, b) | Self::Panel(a, b) => noise(*a, *b),
            Self::RoughMap(a, b) => noise(DVec3::splat(*a), DVec3::splat(*b)),
            _ => String::new(),
        }
    }

    fn named(&self, i: usize) -> String {
        match self {
            Self::Mask(a, b) => format!("Mix m{i} {{ first m{a}  second m{b}  amount t{i} }}"),
            Self::Patterned(..) => format!("Diffuse m{i} {{ reflectance t{i} }}"),
            Self::Bumpy(r, h) => {
                format!("Diffuse m{i} {{ reflectance {}  bump t{i}  bumpHeight {h} }}", VectorText(*r))
            }
            Self::RoughMap(..) => format!("Conductor m{i} {{ metal gold  roughness t{i} }}"),
            Self::Panel(..) => format!("Diffuse m{i} {{ reflectance .5 .5 .5  emission t{i}  emissionScale 3 }}"),
            Self::Diffuse(r) => format!("Diffuse m{i} {{ reflectance {} }}", VectorText(*r)),
            Self::Phong(d, s, n) => {
                format!(
                    "Phong m{i} {{ diffuseColor {}  specularColor {}  shininess {n} }}",
                    VectorText(*d),
                    VectorText(*s)
                )
            }
            Self::Mirror(r) => format!("Mirror m{i} {{ reflectance {} }}", VectorText(*r)),
            Self::Dielectric(n, a, r, p) => {
                let a = VectorText(*a);
                format!("Dielectric m{i} {{ indexOfRefraction {n}  absorption {a}  roughness {r}  priority {p} }}")
            }
            Self::Conductor(r) => format!("Conductor m{i} {{ metal gold  roughness {r} }}"),
            Self::Clear(stuff) => format!("Clear m{i} {{ medium {} }}", stuff.name()),
            Self::Filled(n, stuff) => format!("Dielectric m{i} {{ indexOfRefraction {n}  medium {} }}", stuff.name()),
            Self::Prism(glass) => format!("Dielectric m{i} {{ glass {glass} }}"),
            Self::Thin(n) => format!("Thin m{i} {{ indexOfRefraction {n}  transmittance .9 .8 .7 }}"),
            Self::Mix(a, b, amount) => format!("Mix m{i} {{ first m{a}  second m{b}  amount {amount} }}"),
        }
    }
}

impl Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let emission = match self.emission {
            DVec3::ZERO => String::new(),
            e => format!("  emission {}", VectorText(e)),
        };
        match &self.shape {
            Shape::Sphere(c, r) => write!(f, "Sphere {{ center {}  radius {r}{emission} }}", VectorText(*c)),
            Shape::Ellipsoid(c, turn, axes) => {
                let maps = format!("Translate {}  YRotate {turn}  Scale {}", VectorText(*c), VectorText(*axes));
                write!(f, "Transform {{ {maps}  Sphere {{ center 0 0 0  radius 1{emission} }} }}")
            }
            Shape::Disc(c, n, r) => {
                write!(f, "Disc {{ center {}  normal {}  radius {r}{emission} }}", VectorText(*c), VectorText(*n))
            }
            Shape::Rectangle(c, a, b) => {
                write!(
                    f,
                    "Rectangle {{ corner {}  edge0 {}  edge1 {}{emission} }}",
                    VectorText(*c),
                    VectorText(*a),
                    VectorText(*b)
                )
            }
            Shape::Plane(p, n) => write!(f, "Plane {{ normal {}  offset {} }}", VectorText(*n), n.dot(*p)),
            Shape::Triangle([a, b, c]) => {
                write!(
                    f,
                    "Triangle {{ vertex0 {}  vertex1 {}  vertex2 {}{emission} }}",
                    VectorText(*a),
                    VectorText(*b),
                    VectorText(*c)
                )
            }
            Shape::Mesh(path, c, turn, scale) => {
                let maps = format!("Translate {}  YRotate {turn}  UniformScale {scale}", VectorText(*c));
                write!(f, "Transform {{ {maps}  TriangleMesh {{ obj_file {path}{emission} }} }}")
            }
        }
    }
}

impl Shape {
    pub fn is_flat(&self) -> bool {
        matches!(self, Self::Disc(..) | Self::Rectangle(..) | Self::Plane(..))
    }

    /// Returns points that are spread over the surface; for a plane, points within 100 of its given
    /// point.
    pub fn points(&self) -> Vec<DVec3> {
        let around: Vec<DVec3> = (0..400).map(|i| direction(i, 400)).collect();
        let turned = |turn: f64| DMat3::from_rotation_y(turn.to_radians());
        let lattice = || (0..=20).flat_map(|i| (0..=20).map(move |j| (f64::from(i) / 20.0, f64::from(j) / 20.0)));
        match self {
            Self::Sphere(c, r) => around.iter().map(|d| *c + *d * *r).collect(),
            Self::Ellipsoid(c, turn, axes) => around.iter().map(|d| *c + turned(*turn) * (*d * *axes)).collect(),
            Self::Disc(c, n, r) => projected_directions(*n, &around).map(|d| *c + d * *r).collect(),
            Self::Plane(c, n) => projected_directions(*n, &around).map(|d| *c + d * 100.0).collect(),
            Self::Rectangle(c, a, b) => lattice().map(|(s, t)| *c + *a * s + *b * t).collect(),
            Self::Triangle([a, b, c]) => {
                lattice().filter(|(s, t)| s + t <= 1.0).map(|(s, t)| *a + (*b - *a) * s + (*c - *a) * t).collect()
            }
            Self::Mesh(path, c, turn, scale) => {
                obj_vertices(path).into_iter().map(|p| *c + turned(*turn) * (p * *scale)).collect()
            }
        }
    }
}

/// Returns direction `i` of `n`, spread over the sphere by the golden angle.
fn direction(i: u32, n: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
    let r = (1.0 - z * z).sqrt();
    let (sin, cos) = libm::sincos(2.399_963 * f64::from(i));
    DVec3::new(r * cos, r * sin, z)
}

/// Projects each direction to the plane perpendicular to `n`.
fn projected_directions(n: DVec3, directions: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let n = n.normalize();
    directions.iter().map(move |d| *d - n * n.dot(*d))
}

fn obj_vertices(path: &str) -> Vec<DVec3> {
    let text = fs::read_to_string(project_path(path)).unwrap();
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    let numbers = |line: &str| line.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    lines.map(|line| DVec3::from_slice(&numbers(line))).collect()
}
