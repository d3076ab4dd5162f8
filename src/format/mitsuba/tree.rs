//! Objects of a Mitsuba scene file: elements with values and nested objects.
//!
//! Names of values are in snake case, whatever the version of the file: `toWorld` is `to_world`.

use super::color::ColorValue;
use super::files::Place;
use glam::{DMat4, DVec3};
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// Class of a plugin, by the element that creates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ObjectClass {
    /// The whole scene.
    Scene,
    /// Rendering algorithm.
    Integrator,
    /// Camera.
    Sensor,
    /// Light.
    Emitter,
    /// Surface.
    Shape,
    /// Reflection and transmission of a surface.
    Bsdf,
    /// Function of a surface point, also a spectrum that is written as an object.
    Texture,
    /// Participating medium.
    Medium,
    /// Phase function of a medium.
    Phase,
    /// Function of a point in space.
    Volume,
    /// Picture of a camera.
    Film,
    /// Source of random numbers.
    Sampler,
    /// Pixel filter.
    Filter,
    /// Subsurface scattering of a shape.
    Subsurface,
}

impl ObjectClass {
    /// Returns the class of an element; `None` for elements that are no objects.
    pub fn from_tag(tag: &str) -> Option<Self> {
        Some(match tag {
            "scene" => Self::Scene,
            "integrator" => Self::Integrator,
            "sensor" | "camera" => Self::Sensor,
            "emitter" | "luminaire" => Self::Emitter,
            "shape" => Self::Shape,
            "bsdf" => Self::Bsdf,
            "texture" | "spectrum" => Self::Texture,
            "medium" => Self::Medium,
            "phase" => Self::Phase,
            "volume" => Self::Volume,
            "film" => Self::Film,
            "sampler" => Self::Sampler,
            "rfilter" => Self::Filter,
            "subsurface" => Self::Subsurface,
            _ => return None,
        })
    }
}

/// A value of an object.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// Integer or floating-point number.
    Number(f64),
    /// Truth value.
    Boolean(bool),
    /// Text, such as a file name.
    Text(String),
    /// Point or vector.
    Vector(DVec3),
    /// Affine transform.
    Transform(DMat4),
    /// Color or spectrum.
    Color(ColorValue),
}

/// An object nested in another one: the object itself, or the `id` of an object elsewhere.
#[derive(Clone, Debug)]
pub(super) enum ChildObject {
    /// Object that the element creates.
    Own(Rc<SceneObject>),
    /// Identifier of an object, which may stand later in the file.
    Reference(String, Place),
}

/// An object of the scene file.
#[derive(Debug)]
pub(super) struct SceneObject {
    /// Class of the plugin.
    pub class: ObjectClass,
    /// Name of the plugin, such as `diffuse`.
    pub plugin: String,
    /// Identifier; `None` for an object without `id`.
    pub id: Option<String>,
    /// Position in the file.
    pub place: Place,
    /// Values by name, each with a flag that is true if the importer has read it.
    pub values: BTreeMap<String, (Value, Cell<bool>)>,
    /// Nested objects with their names, in the order of the file.
    pub children: Vec<(String, ChildObject)>,
    /// True if the importer has asked for any value of the object.
    pub is_used: Cell<bool>,
}

/// All objects of a scene file and of the files that it includes.
#[derive(Debug)]
pub(super) struct ObjectTree {
    /// The scene, whose children are all objects at the top.
    pub root: Rc<SceneObject>,
    /// Objects by identifier.
    pub by_id: HashMap<String, Rc<SceneObject>>,
}

impl ObjectTree {
    /// True if a condition holds for an object of the scene.
    pub fn any_object(&self, condition: &dyn Fn(&SceneObject) -> bool) -> bool {
        let mut pending = vec![&self.root];
        while let Some(object) = pending.pop() {
            if condition(object) {
                return true;
            }
            pending.extend(object.own_children());
        }
        false
    }
}

impl SceneObject {
    /// Returns the objects that stand inside of this one in the file.
    pub fn own_children(&self) -> impl Iterator<Item = &Rc<Self>> {
        self.children.iter().filter_map(|(_, child)| match child {
            ChildObject::Own(child) => Some(child),
            ChildObject::Reference(..) => None,
        })
    }

    /// Returns the value called `name`, and marks it as read.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.is_used.set(true);
        let (value, is_read) = self.values.get(name)?;
        is_read.set(true);
        Some(value)
    }

    /// Returns a number; `None` if there is none of this name.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.value(name)? {
            Value::Number(number) => Some(*number),
            Value::Text(text) => text.trim().parse().ok().filter(|number: &f64| number.is_finite()),
            Value::Color(color) => color.uniform(),
            Value::Boolean(_) | Value::Vector(_) | Value::Transform(_) => None,
        }
    }

    /// Returns a truth value; `default` if there is none of this name.
    pub fn boolean(&self, name: &str, default: bool) -> bool {
        match self.value(name) {
            Some(Value::Boolean(value)) => *value,
            Some(Value::Text(text)) => text == "true",
            Some(Value::Number(_) | Value::Vector(_) | Value::Transform(_) | Value::Color(_)) | None => default,
        }
    }

    /// Returns a text; `None` if there is none of this name.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.value(name)? {
            Value::Text(text) => Some(text),
            Value::Number(_) | Value::Boolean(_) | Value::Vector(_) | Value::Transform(_) | Value::Color(_) => None,
        }
    }

    /// Returns a point or vector; `None` if there is none of this name.
    pub fn vector(&self, name: &str) -> Option<DVec3> {
        match self.value(name)? {
            Value::Vector(vector) => Some(*vector),
            Value::Number(_) | Value::Boolean(_) | Value::Text(_) | Value::Transform(_) | Value::Color(_) => None,
        }
    }

    /// Returns a transform; `None` if there is none of this name.
    pub fn transform(&self, name: &str) -> Option<DMat4> {
        match self.value(name)? {
            Value::Transform(matrix) => Some(*matrix),
            Value::Number(_) | Value::Boolean(_) | Value::Text(_) | Value::Vector(_) | Value::Color(_) => None,
        }
    }

    /// Marks all values of the object as read, because a message covers the whole object.
    pub fn mark_as_read(&self) {
        self.values.values().for_each(|(_, is_read)| is_read.set(true));
    }
}
