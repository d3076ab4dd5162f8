//! Access to the objects, files and messages of a Mitsuba scene during its import.

use super::color::{ColorMeaning, ColorValue};
use super::document::unknown_reference_error;
use super::files::{MitsubaSceneFiles, ReadResult};
use super::tree::{ChildObject, MitsubaObject, MitsubaValue, ObjectClass, ObjectTree};
use crate::format::import_notes::ImportNotes;
use glam::DVec3;
use std::cell::RefCell;
use std::rc::Rc;

/// Names of Mitsuba values that the importer ignores without a message.
///
/// They set features that Caustica lacks, such as clipping planes, or details of Mitsuba's
/// renderer.
const SILENTLY_IGNORED_VALUES: [&str; 24] = [
    "accel",
    "banner",
    "component_format",
    "compress",
    "far_clip",
    "file_format",
    "filter_type",
    "focus_distance",
    "hide_emitters",
    "high_quality_edges",
    "label",
    "max_value",
    "mis_compensation",
    "name",
    "near_clip",
    "nonlinear",
    "pixel_format",
    "rr_depth",
    "sample_border",
    "sampling_weight",
    "seed",
    "shutter_close",
    "shutter_open",
    "silhouette_sampling_weight",
];

/// Objects, files and messages of a Mitsuba scene during its import.
pub(super) struct ImportContext<'a> {
    /// Access to the files that the scene refers to.
    pub files: &'a MitsubaSceneFiles<'a>,
    /// All objects of the scene file.
    pub tree: &'a ObjectTree,
    /// Messages about content that is ignored, approximated or added.
    pub notes: RefCell<ImportNotes>,
}

impl ImportContext<'_> {
    /// Adds a message that a part of `object` is ignored or approximated.
    pub fn add_note(&self, message: &str, object: &MitsubaObject) {
        let place = object.place.position_text(&self.files.path.display().to_string());
        let place = match &object.id {
            Some(id) => format!("`{id}`, {place}"),
            None => place,
        };
        self.notes.borrow_mut().add_unsupported(message, place);
    }

    /// Adds a message that the whole `object` is ignored or approximated.
    ///
    /// Marks all its values as read, so that they cause no further messages.
    pub fn add_whole_object_note(&self, message: &str, object: &MitsubaObject) {
        object.mark_as_read();
        self.add_note(message, object);
    }

    /// Returns the objects of class `class`, such as BSDFs, that `object` contains directly. Each
    /// comes with the name that the file gives it inside `object`; the name is empty if there is
    /// none.
    ///
    /// References are replaced by the objects to which they refer.
    ///
    /// # Errors
    /// If a reference has an unknown identifier.
    pub fn children_of_class(
        &self,
        object: &MitsubaObject,
        class: ObjectClass,
    ) -> ReadResult<Vec<(String, Rc<MitsubaObject>)>> {
        let mut found = Vec::new();
        for (name, child) in &object.children {
            let child = match child {
                ChildObject::Own(child) => child,
                ChildObject::Reference(id, place) => {
                    self.tree.by_id.get(id).ok_or_else(|| unknown_reference_error(place, id))?
                }
            };
            if child.class == class {
                found.push((name.clone(), Rc::clone(child)));
            }
        }
        Ok(found)
    }

    /// Returns the object of class `class` inside `object` that is called `name`, or else the first
    /// one without a name; `None` if there is neither.
    pub fn named_or_unnamed_child(
        &self,
        object: &MitsubaObject,
        class: ObjectClass,
        name: &str,
    ) -> ReadResult<Option<Rc<MitsubaObject>>> {
        let children = self.children_of_class(object, class)?;
        let named = children
            .iter()
            .find(|(child_name, _)| child_name == name)
            .or_else(|| children.iter().find(|c| c.0.is_empty()));
        Ok(named.map(|(_, child)| Rc::clone(child)))
    }

    /// Returns the object of class `class` inside `object` that is called `name`; `None` if there
    /// is none.
    pub fn named_child(
        &self,
        object: &MitsubaObject,
        class: ObjectClass,
        name: &str,
    ) -> ReadResult<Option<Rc<MitsubaObject>>> {
        Ok(self
            .children_of_class(object, class)?
            .into_iter()
            .find(|(child_name, _)| child_name == name)
            .map(|(_, child)| child))
    }

    /// Returns the color or spectrum `name` of an object; `None` if it is missing or a texture.
    ///
    /// # Errors
    /// If the value is not a color, or if a nested reference or spectrum is not valid.
    pub fn color_value(&self, object: &MitsubaObject, name: &str) -> ReadResult<Option<ColorValue>> {
        match object.value(name) {
            Some(MitsubaValue::Color(color)) => return Ok(Some(color.clone())),
            Some(MitsubaValue::Number(number)) => return Ok(Some(ColorValue::Uniform(*number))),
            Some(MitsubaValue::Vector(vector)) => return Ok(Some(ColorValue::Rgb(*vector))),
            Some(MitsubaValue::Boolean(_) | MitsubaValue::Text(_) | MitsubaValue::Transform(_)) => {
                let message = format!("`{name}` is not a color");
                return Err(object.place.error(message, "write it as `rgb` or `spectrum`"));
            }
            None => {}
        }
        let Some(texture) = self.named_child(object, ObjectClass::Texture, name)? else { return Ok(None) };
        self.spectrum_from_object(&texture)
    }

    /// Returns the color or spectrum that an object describes, such as a `blackbody`; `None` for
    /// other objects, such as a `bitmap`.
    pub fn spectrum_from_object(&self, object: &MitsubaObject) -> ReadResult<Option<ColorValue>> {
        let scale = || object.number("scale").or_else(|| object.number("value")).unwrap_or(1.0);
        Ok(match object.plugin.as_str() {
            "d65" => match self.color_value(object, "color")? {
                Some(color) => Some(ColorValue::Rgb(color.to_rgb(ColorMeaning::Reflectance) * scale())),
                None => Some(ColorValue::IlluminantD65(scale())),
            },
            "blackbody" => {
                let kelvin = object.number("temperature").filter(|kelvin| *kelvin > 0.0 && *kelvin < 1e9);
                let missing = || {
                    object.place.error("this blackbody has no temperature above 0", "give a `temperature` in kelvin")
                };
                Some(ColorValue::Blackbody(kelvin.ok_or_else(missing)?, object.number("scale").unwrap_or(1.0)))
            }
            "uniform" => Some(ColorValue::Uniform(object.number("value").unwrap_or(1.0))),
            "srgb" | "rgb" => self.color_value(object, "color")?,
            "regular" | "irregular" => Some(self.sampled_spectrum(object)?),
            _ => None,
        })
    }

    /// Returns the spectrum of a `regular` or `irregular` plugin, from its lists of wavelengths and
    /// values.
    fn sampled_spectrum(&self, texture: &MitsubaObject) -> ReadResult<ColorValue> {
        let numbers = |name: &str| texture.text(name).and_then(super::color::parse_numbers);
        let values = numbers("values").unwrap_or_default();
        let wavelengths = numbers("wavelengths").or_else(|| {
            let (low, high) = match numbers("range").as_deref() {
                Some([low, high]) => (*low, *high),
                _ => (texture.number("wavelength_min")?, texture.number("wavelength_max")?),
            };
            let step = (high - low) / (values.len().max(2) - 1) as f64;
            Some((0..values.len()).map(|i| low + step * i as f64).collect())
        });
        let pairs = wavelengths.unwrap_or_default();
        let spectrum = (pairs.len() == values.len()).then(|| {
            crate::color::Spectrum::from_samples(pairs.into_iter().zip(values).map(|(a, b)| [a, b]).collect())
        });
        spectrum.flatten().map(ColorValue::Sampled).ok_or_else(|| {
            texture
                .place
                .error("this spectrum has no list of wavelengths and values", "give as many of both, ascending")
        })
    }

    /// Returns the color `name` of an object as linear RGB; gray of value `default` if the color is
    /// missing or a texture.
    ///
    /// Fails if a component is negative or above 10³⁰.
    pub fn linear_rgb(
        &self,
        object: &MitsubaObject,
        name: &str,
        meaning: ColorMeaning,
        default: f64,
    ) -> ReadResult<DVec3> {
        let color = self.color_value(object, name)?.map_or(DVec3::splat(default), |color| color.to_rgb(meaning));
        if color.min_element() >= 0.0 && color.max_element() <= 1e30 {
            return Ok(color);
        }
        let message = format!("`{name}` is negative or too large");
        Err(object.place.error(message, "give a color whose values are finite and at least 0"))
    }

    /// Adds a message for each unread value of each object that the importer has used.
    ///
    /// Call this after the whole scene is converted.
    pub fn note_unread_values(&self) {
        let mut pending = vec![&self.tree.root];
        while let Some(object) = pending.pop() {
            for (name, (_, is_read)) in &object.values {
                if object.is_used.get() && !is_read.get() && !SILENTLY_IGNORED_VALUES.contains(&name.as_str()) {
                    self.add_note(&format!("`{name}` of `{}` is ignored", object.plugin), object);
                }
            }
            pending.extend(object.own_children());
        }
    }
}
