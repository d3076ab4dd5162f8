//! Groups and shapes.

use super::super::MAX_DEPTH;
use super::super::description::{Curve, CurveBasis, Group, Item, MeshOptions, Object, Shape, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::Parser;
use super::fields::{Fields, Kind};
use super::surfaces;

pub(super) const OBJECTS: [&str; 14] = [
    "Group",
    "Transform",
    "Moving",
    "Sphere",
    "Plane",
    "Disc",
    "Rectangle",
    "Triangle",
    "TriangleMesh",
    "RevSurface",
    "BezierCurve",
    "BsplineCurve",
    "BezierPatch",
    "NurbsSurface",
];
const ENTRIES: [&str; 3] = ["numObjects", "MaterialIndex", "MaterialName"];

pub(super) const EMISSION: (&str, Kind) = ("emission", Kind::Vector);

impl<'a> Parser<'a> {
    pub fn group(&mut self, keyword: Token<'a>) -> Result<Group, SceneError> {
        self.descend(keyword)?;
        let mut items = Vec::new();
        let mut objects = 0;
        let mut count = None;
        while let Some(word) = self.word()? {
            match word.text {
                "numObjects" => self.count(word, &mut count)?,
                "MaterialIndex" => items.push(Item::MaterialIndex(self.material_by_index(word)?)),
                "MaterialName" => items.push(Item::MaterialName(self.material_by_name(word)?)),
                text if OBJECTS.contains(&text) => {
                    items.push(Item::Object(self.object(word)?));
                    objects += 1;
                }
                _ => return Err(self.unexpected(word, &[&ENTRIES[..], &OBJECTS].concat())),
            }
        }
        self.depth -= 1;
        self.check_count("numObjects", count, objects, "object")?;
        Ok(Group { items })
    }

    /// On the heap at once, so that what nests keeps small frames on the stack.
    pub fn boxed(&mut self, keyword: Token<'a>) -> Result<Box<Spanned<Object>>, SceneError> {
        self.object(keyword).map(Box::new)
    }

    fn object(&mut self, keyword: Token<'a>) -> Result<Spanned<Object>, SceneError> {
        let object = match keyword.text {
            "Group" => Object::Group(self.group(keyword)?),
            "Transform" => {
                let (maps, object) = self.transform(keyword)?;
                Object::Transform { maps, object }
            }
            "Moving" => {
                let (maps, object) = self.moving(keyword, &OBJECTS, Self::boxed)?;
                Object::Moving { maps, object }
            }
            _ => self.shape(keyword)?,
        };
        Ok(Spanned::new(object, keyword.span()))
    }

    // Apart, so that what nests keeps small frames on the stack.
    #[inline(never)]
    fn shape(&mut self, keyword: Token<'a>) -> Result<Object, SceneError> {
        use Kind::{Name, Number, Pair, Vector};
        let known: &[(&str, Kind)] = match keyword.text {
            "Sphere" => &[("center", Vector), ("radius", Number), EMISSION],
            "Plane" => &[("normal", Vector), ("offset", Number), EMISSION],
            "Disc" => &[("center", Vector), ("normal", Vector), ("radius", Number), EMISSION],
            "Rectangle" => &[("corner", Vector), ("edge0", Vector), ("edge1", Vector), EMISSION],
            "Triangle" => &[
                ("vertex0", Vector),
                ("vertex1", Vector),
                ("vertex2", Vector),
                ("normal0", Vector),
                ("normal1", Vector),
                ("normal2", Vector),
                ("uv0", Pair),
                ("uv1", Pair),
                ("uv2", Pair),
                EMISSION,
            ],
            "TriangleMesh" => &[
                ("obj_file", Name),
                ("file", Name),
                ("materials", Name),
                ("normals", Name),
                ("smoothAngle", Number),
                EMISSION,
            ],
            "RevSurface" => &[("profile", Kind::Curve), EMISSION],
            "BezierPatch" => surfaces::PATCHES,
            "NurbsSurface" => surfaces::NURBS,
            _ => &[("controls", Kind::Controls), EMISSION],
        };
        let f = self.fields(keyword, known)?;
        let shape = match keyword.text {
            "Sphere" => Shape::Sphere { center: f.need("center")?.vector(), radius: f.need("radius")?.positive()? },
            "Plane" => Shape::Plane { normal: f.need("normal")?.direction()?, offset: f.need("offset")?.number() },
            "Disc" => Shape::Disc {
                center: f.need("center")?.vector(),
                normal: f.need("normal")?.direction()?,
                radius: f.need("radius")?.positive()?,
            },
            "Rectangle" => {
                let (corner, edge0, edge1) = f.rectangle()?;
                Shape::Rectangle { corner, edge0, edge1 }
            }
            "Triangle" => {
                let vertex = |name| f.need(name).map(|v| v.vector());
                let vertices = [vertex("vertex0")?, vertex("vertex1")?, vertex("vertex2")?];
                let names = ["normal0", "normal1", "normal2"];
                let normal = |name| f.need(name)?.direction();
                let normals = match names.iter().any(|name| f.get(name).is_some()) {
                    true => Some([normal(names[0])?, normal(names[1])?, normal(names[2])?]),
                    false => None,
                };
                let names = ["uv0", "uv1", "uv2"];
                let pair = |name| f.need(name).map(|p| p.pair());
                let uv = match names.iter().any(|name| f.get(name).is_some()) {
                    true => Some(Box::new([pair(names[0])?, pair(names[1])?, pair(names[2])?])),
                    false => None,
                };
                Shape::Triangle { vertices, normals, uv }
            }
            "TriangleMesh" => Shape::Mesh { path: f.one_of(&["obj_file", "file"])?.text(), options: f.mesh_options()? },
            "RevSurface" => Shape::Revolution { profile: f.need("profile")?.curve() },
            "BezierPatch" => f.patches()?,
            "NurbsSurface" => f.nurbs()?,
            "BezierCurve" => Shape::Curve(f.need("controls")?.controls(CurveBasis::Bezier)?),
            _ => Shape::Curve(f.need("controls")?.controls(CurveBasis::Bspline)?),
        };
        Ok(Object::Shape { shape, emission: f.emission()? })
    }

    /// The curve after `profile`; its span is its keyword.
    pub fn profile(&mut self) -> Result<Spanned<Curve>, SceneError> {
        let keyword = self.lexer.peek();
        let basis = match keyword.text {
            "BezierCurve" => CurveBasis::Bezier,
            "BsplineCurve" => CurveBasis::Bspline,
            "" => return Err(self.unclosed()),
            text => {
                let message = format!("`profile` wants a curve, found `{}`", super::clip(text));
                let help = "write `profile BezierCurve { … }` or `profile BsplineCurve { … }`".to_owned();
                return Err(self.lexer.error(keyword.span(), message, "a curve belongs here", help));
            }
        };
        self.lexer.take(keyword);
        let f = self.fields(keyword, &[("controls", Kind::Controls)])?;
        Ok(Spanned::new(f.need("controls")?.controls(basis)?, keyword.span()))
    }

    /// Reads the `}` of a block without fields.
    pub fn close(&mut self) -> Result<(), SceneError> {
        self.punctuation("}")?;
        self.open.pop();
        Ok(())
    }

    /// Opens a block that may hold others of its kind.
    pub fn descend(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
        if self.depth == MAX_DEPTH {
            let message = format!("groups and transforms nest more than {MAX_DEPTH} deep");
            let help = "list the objects side by side instead".to_owned();
            return Err(self.lexer.error(keyword.span(), message, "too deep", help));
        }
        self.depth += 1;
        self.open(keyword)
    }
}

impl Fields<'_> {
    fn mesh_options(&self) -> Result<MeshOptions, SceneError> {
        let is = |name: &str, usual: &str, other: &str| match self.get(name) {
            Some(field) => {
                let word = field.text().value;
                field.ensure(word == usual || word == other, &format!("must be `{usual}` or `{other}`"))?;
                Ok(word == other)
            }
            None => Ok(false),
        };
        let angle = self.get("smoothAngle");
        if let Some(angle) = angle {
            angle.ensure((0.0..=180.0).contains(&angle.number()), "must lie between 0 and 180")?;
        }
        Ok(MeshOptions {
            own_materials: is("materials", "scene", "file")?,
            no_normals: is("normals", "file", "none")?,
            smooth_angle: angle.map(|angle| angle.number()),
        })
    }
}
