//! Tree of the objects of a Mitsuba scene file. An object has named values and nested objects.
//!
//! Names are in snake case, also for old files: `toWorld` is `to_world`.

use super::color::ColorValue;
use super::files::MitsubaSourceLocation;
use glam::{DMat4, DVec3};
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// Class of an object, from the name of its XML element, such as `bsdf`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ObjectClass {
    /// The whole scene.
    Scene,
    /// Rendering algorithm.
    Integrator,
    /// Camera.
    Sensor,
    /// Light, or the emission of a shape.
    Emitter,
    /// Geometry with a material; also an instance or a group of shapes.
    Shape,
    /// Reflection and transmission of a surface (its material).
    Bsdf,
    /// Texture, or a spectrum that the file writes as an object with a plugin.
    Texture,
    /// Participating medium.
    Medium,
    /// Phase function of a medium.
    PhaseFunction,
    /// Volume: a function of the position in space, such as the density of a medium.
    Volume,
    /// Film of a sensor, which states the size of the picture.
    Film,
    /// Sampler: source of random numbers.
    Sampler,
    /// Reconstruction filter of the film.
    Filter,
    /// Subsurface scattering of a shape.
    Subsurface,
}

impl ObjectClass {
    /// Returns the class of objects from XML elements called `tag`; `None` if such elements are no
    /// objects.
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
            "phase" => Self::PhaseFunction,
            "volume" => Self::Volume,
            "film" => Self::Film,
            "sampler" => Self::Sampler,
            "rfilter" => Self::Filter,
            "subsurface" => Self::Subsurface,
            _ => return None,
        })
    }
}

/// A value of an object, such as a number or a transform.
#[derive(Clone, Debug)]
pub(super) enum MitsubaValue {
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

/// An object nested in another one, or a reference to an object elsewhere in the file.
#[derive(Clone, Debug)]
pub(super) enum ChildObject {
    /// The nested object itself.
    Own(Rc<MitsubaObject>),
    /// Identifier of the object, and the position of the reference. The object may be defined later
    /// in the file.
    Reference(String, MitsubaSourceLocation),
}

/// An object of the scene file: an instance of a Mitsuba plugin.
#[derive(Debug)]
pub(super) struct MitsubaObject {
    /// Class of the object, such as BSDF or emitter.
    pub class: ObjectClass,
    /// Name of the object's Mitsuba plugin, such as `diffuse`.
    pub plugin: String,
    /// Identifier by which references name the object; `None` without one.
    pub id: Option<String>,
    /// Position of the object in the file.
    pub place: MitsubaSourceLocation,
    /// Values by name. The flag of each value is true if the importer has read it.
    pub values: BTreeMap<String, (MitsubaValue, Cell<bool>)>,
    /// Nested objects, each with its name inside this object, in the order of the file.
    pub children: Vec<(String, ChildObject)>,
    /// True if the importer has looked up a value of the object. Only such objects cause messages
    /// about values that were never read.
    pub is_used: Cell<bool>,
}

/// All objects of a scene file and of the files that it includes.
#[derive(Debug)]
pub(super) struct ObjectTree {
    /// Root object. Its children are the objects at the top level of the file.
    pub root: Rc<MitsubaObject>,
    /// Objects by identifier.
    pub by_id: HashMap<String, Rc<MitsubaObject>>,
    /// True if the file states a version before 1. Such files have other default values.
    pub has_version_zero: bool,
}

impl ObjectTree {
    /// True if `condition` holds for any object of the scene.
    pub fn any_object(&self, condition: &dyn Fn(&MitsubaObject) -> bool) -> bool {
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

impl MitsubaObject {
    /// Returns the objects that are nested in this one directly. Objects to which this one only
    /// refers are not among them.
    pub fn own_children(&self) -> impl Iterator<Item = &Rc<Self>> {
        self.children.iter().filter_map(|(_, child)| match child {
            ChildObject::Own(child) => Some(child),
            ChildObject::Reference(..) => None,
        })
    }

    /// Returns the value called `name`, and marks it as read; `None` if the object has none.
    pub fn value(&self, name: &str) -> Option<&MitsubaValue> {
        self.is_used.set(true);
        let (value, is_read) = self.values.get(name)?;
        is_read.set(true);
        Some(value)
    }

    /// Returns the number called `name`; `None` if there is none, or if the value is no number.
    ///
    /// Texts that spell a number, uniform spectra and grays count as numbers.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.value(name)? {
            MitsubaValue::Number(number) => Some(*number),
            MitsubaValue::Text(text) => text.trim().parse().ok().filter(|number: &f64| number.is_finite()),
            MitsubaValue::Color(color) => color.uniform_value(),
            MitsubaValue::Boolean(_) | MitsubaValue::Vector(_) | MitsubaValue::Transform(_) => None,
        }
    }

    /// Returns the truth value called `name`; `default` if there is none, or if it has another
    /// type.
    ///
    /// A text counts as a truth value: `true` is true, and any other text is false.
    pub fn boolean(&self, name: &str, default: bool) -> bool {
        match self.value(name) {
            Some(MitsubaValue::Boolean(value)) => *value,
            Some(MitsubaValue::Text(text)) => text == "true",
            Some(
                MitsubaValue::Number(_) | MitsubaValue::Vector(_) | MitsubaValue::Transform(_) | MitsubaValue::Color(_),
            )
            | None => default,
        }
    }

    /// Returns the text called `name`; `None` if there is none, or if the value has another type.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.value(name)? {
            MitsubaValue::Text(text) => Some(text),
            MitsubaValue::Number(_)
            | MitsubaValue::Boolean(_)
            | MitsubaValue::Vector(_)
            | MitsubaValue::Transform(_)
            | MitsubaValue::Color(_) => None,
        }
    }

    /// Returns the point or vector called `name`; `None` if there is none, or if it has another
    /// type.
    pub fn vector(&self, name: &str) -> Option<DVec3> {
        match self.value(name)? {
            MitsubaValue::Vector(vector) => Some(*vector),
            MitsubaValue::Number(_)
            | MitsubaValue::Boolean(_)
            | MitsubaValue::Text(_)
            | MitsubaValue::Transform(_)
            | MitsubaValue::Color(_) => None,
        }
    }

    /// Returns the transform called `name`; `None` if there is none, or if the value has another
    /// type.
    pub fn transform(&self, name: &str) -> Option<DMat4> {
        match self.value(name)? {
            MitsubaValue::Transform(matrix) => Some(*matrix),
            MitsubaValue::Number(_)
            | MitsubaValue::Boolean(_)
            | MitsubaValue::Text(_)
            | MitsubaValue::Vector(_)
            | MitsubaValue::Color(_) => None,
        }
    }

    /// Marks all values of the object as read, so that they cause no messages.
    ///
    /// Use this if one message covers the whole object.
    pub fn mark_as_read(&self) {
        self.values.values().for_each(|(_, is_read)| is_read.set(true));
    }
}
