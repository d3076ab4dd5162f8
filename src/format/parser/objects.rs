//! Groups, transforms and shapes.

use glam::{DMat4, DVec3};

use super::super::MAX_DEPTH;
use super::super::description::{Curve, CurveBasis, Group, Item, Map, MeshOptions, Object, Shape, Span, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::Parser;
use super::fields::{Fields, Kind};
use crate::math::Transform;

const OBJECTS: [&str; 11] = [
    "Group",
    "Transform",
    "Sphere",
    "Plane",
    "Disc",
    "Rectangle",
    "Triangle",
    "TriangleMesh",
    "RevSurface",
    "BezierCurve",
    "BsplineCurve",
];
const ENTRIES: [&str; 3] = ["numObjects", "MaterialIndex", "MaterialName"];
const MAPS: [&str; 9] =
    ["Scale", "UniformScale", "Translate", "XRotate", "YRotate", "ZRotate", "Rotate", "Matrix4f", "Matrix"];

const EMISSION: (&str, Kind) = ("emission", Kind::Vector);

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

    fn object(&mut self, keyword: Token<'a>) -> Result<Spanned<Object>, SceneError> {
        let object = match keyword.text {
            "Group" => Object::Group(self.group(keyword)?),
            "Transform" => self.transform(keyword)?,
            _ => self.shape(keyword)?,
        };
        Ok(Spanned::new(object, keyword.span()))
    }

    fn transform(&mut self, keyword: Token<'a>) -> Result<Object, SceneError> {
        self.descend(keyword)?;
        let mut maps = Vec::new();
        let object = loop {
            match self.word()? {
                None => {
                    let message = "`Transform` holds no object".to_owned();
                    let help = "put an object after its maps: `Transform { Scale 2 2 2 Sphere { … } }`".to_owned();
                    return Err(self.lexer.error(keyword.span(), message, "this block", help));
                }
                Some(word) if MAPS.contains(&word.text) => maps.push(self.map(word)?),
                Some(word) if OBJECTS.contains(&word.text) => break Box::new(self.object(word)?),
                Some(word) => return Err(self.unexpected(word, &[&MAPS[..], &OBJECTS].concat())),
            }
        };
        if let Some(word) = self.word()? {
            let message = format!("unexpected `{}` after the object of `Transform`", super::clip(word.text));
            let help = "maps stand before the object; put several objects into a Group".to_owned();
            return Err(self.lexer.error(word.span(), message, "`}` belongs here", help));
        }
        if Transform::new(Map::product(&maps)).is_err() {
            return Err(self.singular(keyword.span(), "this `Transform` flattens its object"));
        }
        self.depth -= 1;
        Ok(Object::Transform { maps, object })
    }

    fn map(&mut self, word: Token<'a>) -> Result<Map, SceneError> {
        let (map, span) = match word.text {
            "Scale" | "Translate" => {
                let v = self.numbers(word)?;
                let vector = DVec3::from_array(v.value);
                (if word.text == "Scale" { Map::Scale(vector) } else { Map::Translate(vector) }, v.span)
            }
            "Rotate" => {
                self.open(word)?;
                let v = self.numbers::<4>(word)?;
                let [x, y, z, angle] = v.value;
                let axis = DVec3::new(x, y, z);
                self.close()?;
                if !super::has_direction(axis) {
                    let message = "the axis of `Rotate` must have a length above 0 (and below 1e154)".to_owned();
                    let help = "write axis and degrees: `Rotate { 0 1 0 90 }`".to_owned();
                    return Err(self.lexer.error(v.span, message, "this axis", help));
                }
                (Map::Rotate { axis, angle }, v.span)
            }
            "Matrix4f" | "Matrix" => {
                self.open(word)?;
                let m = self.numbers::<16>(word)?;
                self.close()?;
                let matrix = DMat4::from_cols_array(&m.value);
                if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
                    let message = format!("the fourth row of `{}` must be 0 0 0 1", word.text);
                    let help = "columns are listed one after the other: every fourth number is 0, the last is 1";
                    return Err(self.lexer.error(m.span, message, "this matrix", help.to_owned()));
                }
                (Map::Matrix(matrix), m.span)
            }
            _ => {
                let v = self.numbers::<1>(word)?;
                let map = match (word.text, v.value[0]) {
                    ("XRotate", angle) => Map::RotateX(angle),
                    ("YRotate", angle) => Map::RotateY(angle),
                    ("ZRotate", angle) => Map::RotateZ(angle),
                    (_, scale) => Map::UniformScale(scale),
                };
                (map, v.span)
            }
        };
        match Transform::new(map.matrix()) {
            Ok(_) => Ok(map),
            Err(_) => Err(self.singular(span, &format!("`{}` flattens its object", word.text))),
        }
    }

    fn singular(&self, span: Span, message: &str) -> SceneError {
        let help = "scales must not be 0, nor the columns of a matrix lie in one plane; for flat shapes use Disc, \
                    Rectangle or Triangle";
        self.lexer.error(span, message.to_owned(), "singular", help.to_owned())
    }

    fn shape(&mut self, keyword: Token<'a>) -> Result<Object, SceneError> {
        use Kind::{Name, Number, Vector};
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
                Shape::Triangle { vertices, normals }
            }
            "TriangleMesh" => Shape::Mesh { path: f.one_of(&["obj_file", "file"])?.text(), options: f.mesh_options()? },
            "RevSurface" => Shape::Revolution { profile: f.need("profile")?.curve() },
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
    fn close(&mut self) -> Result<(), SceneError> {
        self.punctuation("}")?;
        self.open.pop();
        Ok(())
    }

    /// Opens a block that may hold others of its kind.
    fn descend(&mut self, keyword: Token<'a>) -> Result<(), SceneError> {
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
