//! From description back to text, in one canonical form that the course's parser reads too where it can.

mod lights;
mod materials;
mod media;
mod textures;

use std::fmt::{Display, Formatter, Result};

use glam::{DVec3, DVec4};

use super::description::{
    Aim, Camera, Curve, CurveBasis, Description, Focus, Group, Item, Lens, Map, Object, Opening, Projection, Shape,
    Spanned,
};

impl Display for Description {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let mut out = Printer { f, depth: 0 };
        out.camera(&self.camera)?;
        out.open("Background")?;
        out.vector("color", self.background)?;
        self.filling.as_ref().map_or(Ok(()), |medium| out.field("medium", Name(medium)))?;
        out.close()?;
        if !self.lights.is_empty() {
            out.open("Lights")?;
            out.field("numLights", self.lights.len())?;
            self.lights.iter().try_for_each(|light| out.light(light))?;
            out.close()?;
        }
        if !self.textures.is_empty() {
            out.open("Textures")?;
            out.field("numTextures", self.textures.len())?;
            self.textures.iter().try_for_each(|texture| out.texture(texture))?;
            out.close()?;
        }
        if !self.media.is_empty() {
            out.open("Media")?;
            out.field("numMedia", self.media.len())?;
            self.media.iter().try_for_each(|medium| out.medium(medium))?;
            out.close()?;
        }
        if !self.materials.is_empty() {
            out.open("Materials")?;
            out.field("numMaterials", self.materials.len())?;
            self.materials.iter().try_for_each(|material| out.material(material))?;
            out.close()?;
        }
        out.group(&self.root)
    }
}

struct Printer<'f, 'a> {
    f: &'f mut Formatter<'a>,
    depth: usize,
}

impl Printer<'_, '_> {
    fn line(&mut self, text: impl Display) -> Result {
        writeln!(self.f, "{:1$}{text}", "", 4 * self.depth)
    }

    fn field(&mut self, name: &str, value: impl Display) -> Result {
        self.line(format_args!("{name} {value}"))
    }

    fn number(&mut self, name: &str, value: f64) -> Result {
        self.field(name, Number(value))
    }

    fn vector(&mut self, name: &str, value: DVec3) -> Result {
        self.field(name, Numbers(&value.to_array()))
    }

    fn optional(&mut self, name: &str, value: Option<DVec3>) -> Result {
        value.map_or(Ok(()), |value| self.vector(name, value))
    }

    fn open(&mut self, keyword: impl Display) -> Result {
        self.line(format_args!("{keyword} {{"))?;
        self.depth += 1;
        Ok(())
    }

    fn close(&mut self) -> Result {
        self.depth -= 1;
        self.line("}")
    }

    fn aim(&mut self, aim: Aim) -> Result {
        match aim {
            Aim::Direction(direction) => self.vector("direction", direction),
            Aim::LookAt(point) => self.vector("lookAt", point),
        }
    }

    fn camera(&mut self, camera: &Camera) -> Result {
        if !camera.motion.is_empty() {
            self.open("Moving")?;
            camera.motion.iter().try_for_each(|map| self.map(map))?;
        }
        self.open(match camera.projection {
            Projection::Perspective { .. } => "PerspectiveCamera",
            Projection::Orthographic { .. } => "OrthographicCamera",
            Projection::Environment => "EnvironmentCamera",
        })?;
        self.vector("center", camera.center)?;
        self.aim(camera.aim)?;
        self.vector("up", camera.up)?;
        match camera.projection {
            Projection::Perspective { angle, lens } => {
                self.number("angle", angle)?;
                lens.map_or(Ok(()), |lens| self.lens(&lens))?;
            }
            Projection::Orthographic { size } => self.number("size", size)?,
            Projection::Environment => {}
        }
        self.field("width", camera.width)?;
        self.field("height", camera.height)?;
        if !camera.motion.is_empty() {
            self.close()?;
        }
        self.close()
    }

    fn lens(&mut self, lens: &Lens) -> Result {
        match lens.opening {
            Opening::Radius(radius) => self.number("aperture", radius)?,
            Opening::FNumber { number, sensor } => {
                self.number("fNumber", number)?;
                self.number("sensorHeight", sensor)?;
            }
        }
        match lens.focus {
            Focus::Distance(distance) => self.number("focusDistance", distance)?,
            Focus::Point(point) => self.vector("focusAt", point)?,
        }
        self.field("blades", lens.blades)
    }

    fn group(&mut self, group: &Group) -> Result {
        self.open("Group")?;
        let objects = group.items.iter().filter(|item| matches!(item, Item::Object(_))).count();
        self.field("numObjects", objects)?;
        for item in &group.items {
            match item {
                Item::MaterialIndex(index) => self.field("MaterialIndex", index.value)?,
                Item::MaterialName(name) => self.field("MaterialName", Name(name))?,
                Item::Object(object) => self.object(object)?,
            }
        }
        self.close()
    }

    fn object(&mut self, object: &Spanned<Object>) -> Result {
        match &object.value {
            Object::Group(group) => self.group(group),
            Object::Transform { maps, object } => {
                self.open("Transform")?;
                maps.iter().try_for_each(|map| self.map(map))?;
                self.object(object)?;
                self.close()
            }
            Object::Moving { maps, object } => {
                self.open("Moving")?;
                maps.iter().try_for_each(|map| self.map(map))?;
                self.object(object)?;
                self.close()
            }
            Object::Shape { shape, emission } => self.shape(shape, *emission),
        }
    }

    fn map(&mut self, map: &Map) -> Result {
        match *map {
            Map::Scale(s) => self.vector("Scale", s),
            Map::UniformScale(s) => self.number("UniformScale", s),
            Map::Translate(t) => self.vector("Translate", t),
            Map::RotateX(angle) => self.number("XRotate", angle),
            Map::RotateY(angle) => self.number("YRotate", angle),
            Map::RotateZ(angle) => self.number("ZRotate", angle),
            Map::Rotate { axis, angle } => {
                let numbers = [axis.x, axis.y, axis.z, angle];
                self.field("Rotate", format_args!("{{ {} }}", Numbers(&numbers)))
            }
            Map::Matrix(m) => self.field("Matrix4f", format_args!("{{ {} }}", Numbers(&m.to_cols_array()))),
        }
    }

    // Kept out of the functions that call each other for what nests: their stack is to stay small.
    #[inline(never)]
    fn shape(&mut self, shape: &Shape, emission: Option<DVec3>) -> Result {
        match shape {
            Shape::Sphere { center, radius } => {
                self.open("Sphere")?;
                self.vector("center", *center)?;
                self.number("radius", *radius)?;
            }
            Shape::Plane { normal, offset } => {
                self.open("Plane")?;
                self.vector("normal", *normal)?;
                self.number("offset", *offset)?;
            }
            Shape::Disc { center, normal, radius } => {
                self.open("Disc")?;
                self.vector("center", *center)?;
                self.vector("normal", *normal)?;
                self.number("radius", *radius)?;
            }
            Shape::Rectangle { corner, edge0, edge1 } => {
                self.open("Rectangle")?;
                self.rectangle(*corner, *edge0, *edge1)?;
            }
            Shape::Triangle { vertices, normals, uv } => {
                self.open("Triangle")?;
                for (i, vertex) in vertices.iter().enumerate() {
                    self.vector(&format!("vertex{i}"), *vertex)?;
                }
                for (i, normal) in normals.iter().flatten().enumerate() {
                    self.vector(&format!("normal{i}"), *normal)?;
                }
                for (i, uv) in uv.iter().flat_map(|uv| uv.iter()).enumerate() {
                    self.pair(&format!("uv{i}"), *uv)?;
                }
            }
            Shape::Mesh { path, options } => {
                self.open("TriangleMesh")?;
                let ply = path.to_ascii_lowercase().ends_with(".ply");
                self.field(if ply { "file" } else { "obj_file" }, Name(path))?;
                if options.own_materials {
                    self.field("materials", "file")?;
                }
                if options.no_normals {
                    self.field("normals", "none")?;
                }
                options.smooth_angle.map_or(Ok(()), |angle| self.number("smoothAngle", angle))?;
            }
            Shape::Revolution { profile } => {
                self.open("RevSurface")?;
                self.curve("profile ", profile)?;
                self.close()?;
            }
            Shape::Curve(curve) => self.curve("", curve)?,
            Shape::Patches { degree, controls } => {
                self.open("BezierPatch")?;
                self.degrees(degree)?;
                self.net(controls)?;
            }
            Shape::Nurbs { degree, count, knots, controls } => {
                self.open("NurbsSurface")?;
                self.degrees(degree)?;
                self.field("countU", count[0])?;
                self.field("countV", count[1])?;
                for (name, knots) in ["knotsU", "knotsV"].into_iter().zip(knots).filter(|(_, k)| !k.is_empty()) {
                    self.field(name, Numbers(knots))?;
                }
                self.net(controls)?;
            }
        }
        self.optional("emission", emission)?;
        self.close()
    }

    fn rectangle(&mut self, corner: DVec3, edge0: DVec3, edge1: DVec3) -> Result {
        self.vector("corner", corner)?;
        self.vector("edge0", edge0)?;
        self.vector("edge1", edge1)
    }

    /// All of a curve but its last brace.
    fn curve(&mut self, before: &str, curve: &Curve) -> Result {
        let keyword = match curve.basis {
            CurveBasis::Bezier => "BezierCurve",
            CurveBasis::Bspline => "BsplineCurve",
        };
        self.open(format_args!("{before}{keyword}"))?;
        self.line("controls")?;
        curve.controls.iter().try_for_each(|point| self.line(format_args!("    [ {} ]", Numbers(&point.to_array()))))
    }
}

impl Printer<'_, '_> {
    fn degrees(&mut self, degree: &[u32; 2]) -> Result {
        self.field("degreeU", degree[0])?;
        self.field("degreeV", degree[1])
    }

    /// Points, with their weights unless all are 1.
    fn net(&mut self, controls: &[DVec4]) -> Result {
        self.line("controls")?;
        let numbers = if controls.iter().all(|c| c.w == 1.0) { 3 } else { 4 };
        controls.iter().try_for_each(|c| self.line(format_args!("    [ {} ]", Numbers(&c.to_array()[..numbers]))))
    }
}

/// The shortest text that reads back as the same number, by exponent where that is far from 1.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0.abs() {
            0.0 | 1e-5..1e16 => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

struct Numbers<'a>(&'a [f64]);

impl Display for Numbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, number) in self.0.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            write!(f, "{gap}{}", Number(*number))?;
        }
        Ok(())
    }
}

/// A path or name, bare where it reads back so.
struct Name<'a>(&'a str);

impl Display for Name<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let name = self.0;
        let plain = |c: char| !c.is_whitespace() && !c.is_control() && !"\"{}".contains(c);
        let comment = name.starts_with('#') || name.starts_with("//");
        if !name.is_empty() && !comment && name.chars().all(plain) { f.write_str(name) } else { Quoted(name).fmt(f) }
    }
}

struct Quoted<'a>(&'a str);

impl Display for Quoted<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "\"{}\"", self.0.replace('\\', "\\\\").replace('"', "\\\""))
    }
}
