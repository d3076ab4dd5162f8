//! Objects of a Tungsten scene: JSON objects with their place in the file.

use crate::format::SceneError;
pub(super) use crate::format::import::ReadResult;
use crate::format::import::SceneReadError;
use glam::DVec3;
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Display;

/// Record of the JSON objects that the importer has visited, and of their members that it has read.
///
/// At the end of the import, members that were not read cause messages. So there is no list of
/// unknown names to maintain.
#[derive(Default)]
pub(super) struct ReadRecord<'a> {
    /// Visited objects by place.
    visited: RefCell<BTreeMap<String, &'a Map<String, Value>>>,
    /// Addresses of the members that have been read.
    read: RefCell<HashSet<*const Value>>,
}

impl<'a> ReadRecord<'a> {
    /// Returns the place and the name of each member of a used object that has not been read. An
    /// object whose `type` has not been read is not used.
    pub fn unread_members(&self) -> Vec<(String, &'a str)> {
        let (visited, read) = (self.visited.borrow(), self.read.borrow());
        let is_read = |value: &Value| read.contains(&std::ptr::from_ref(value));
        let used = visited.iter().filter(|(_, members)| members.get("type").is_none_or(is_read));
        let unread = used.flat_map(|(place, members)| {
            let members = members.iter().filter(|(_, value)| !is_read(value));
            members.map(|(name, _)| (place.clone(), name.as_str()))
        });
        unread.collect()
    }
}

/// A JSON object of the scene file, with its place in the file.
#[derive(Clone)]
pub(super) struct TungstenObject<'a> {
    members: &'a Map<String, Value>,
    record: &'a ReadRecord<'a>,
    /// Name of the scene file, for errors.
    file: &'a str,
    /// Place of the object in the file, such as `bsdfs[3]`.
    place: String,
}

impl<'a> TungstenObject<'a> {
    /// Returns the object with the given `members` at `place` of the scene file called `file`.
    pub fn new(file: &'a str, record: &'a ReadRecord<'a>, members: &'a Map<String, Value>, place: String) -> Self {
        record.visited.borrow_mut().insert(place.clone(), members);
        Self { members, record, file, place }
    }

    /// Returns the address of the object's members, which identifies the object.
    pub fn key(&self) -> *const Map<String, Value> {
        self.members
    }

    /// Returns the value of the member `name`, and records that it was read; `None` if the member
    /// is missing.
    pub fn value(&self, name: &str) -> Option<&'a Value> {
        let value = self.members.get(name)?;
        self.record.read.borrow_mut().insert(value);
        Some(value)
    }

    /// Records that all members were read, so that they cause no messages.
    pub fn mark_as_read(&self) {
        self.record.read.borrow_mut().extend(self.members.values().map(std::ptr::from_ref));
    }

    /// Returns the name that the file gives the object; empty without one.
    pub fn name(&self) -> &'a str {
        self.value("name").and_then(Value::as_str).unwrap_or_default()
    }

    /// Returns the kind of the object, its member `type`.
    ///
    /// # Errors
    /// If the object has no text `type`.
    pub fn kind(&self) -> ReadResult<&'a str> {
        self.text("type")?.ok_or_else(|| self.error("this object has no `type`", "state its kind as `type`"))
    }

    /// Returns the place of the object with its name, for messages, such as `bsdfs[3], "glass"`.
    pub fn label(&self) -> String {
        match self.members.get("name").and_then(Value::as_str) {
            Some(name) if !name.is_empty() => format!("{} `{name}`", self.place),
            _ => self.place.clone(),
        }
    }

    /// Returns an error about this object, with the remedy `help`.
    pub fn error(&self, message: impl Display, help: &str) -> SceneReadError {
        SceneError::error_without_position(self.file, format!("{}: {message}", self.label()), help).into()
    }

    /// Returns an error that the member `name` is not `expected`, such as `a number`.
    fn type_error(&self, name: &str, expected: &str) -> SceneReadError {
        self.error(format!("`{name}` is not {expected}"), &format!("write `{name}` as {expected}"))
    }

    /// Returns the number `name`; `None` if it is missing.
    pub fn number(&self, name: &str) -> ReadResult<Option<f64>> {
        let Some(value) = self.value(name) else { return Ok(None) };
        value.as_f64().filter(|number| number.is_finite()).map(Some).ok_or_else(|| self.type_error(name, "a number"))
    }

    /// Returns the number `name`, or `default` if it is missing. Fails if it is outside `range`.
    pub fn number_in(&self, name: &str, default: f64, range: std::ops::RangeInclusive<f64>) -> ReadResult<f64> {
        let number = self.number(name)?.unwrap_or(default);
        if range.contains(&number) {
            return Ok(number);
        }
        let message = format!("`{name}` is {number}, which is not from {} to {}", range.start(), range.end());
        Err(self.error(message, "correct the number"))
    }

    /// Returns the truth value `name`, or `default` if it is missing.
    pub fn boolean(&self, name: &str, default: bool) -> ReadResult<bool> {
        let Some(value) = self.value(name) else { return Ok(default) };
        value.as_bool().ok_or_else(|| self.type_error(name, "`true` or `false`"))
    }

    /// Returns the text `name`; `None` if it is missing.
    pub fn text(&self, name: &str) -> ReadResult<Option<&'a str>> {
        let Some(value) = self.value(name) else { return Ok(None) };
        value.as_str().map(Some).ok_or_else(|| self.type_error(name, "a text"))
    }

    /// Returns the vector or color `name`; `None` if it is missing. One number stands for three
    /// equal components.
    pub fn vector(&self, name: &str) -> ReadResult<Option<DVec3>> {
        let Some(value) = self.value(name) else { return Ok(None) };
        vector_of(value).map(Some).ok_or_else(|| self.type_error(name, "a number or a list of three numbers"))
    }

    /// Returns the list `name` as numbers; `None` if the member is missing or no list of numbers.
    pub fn number_list(&self, name: &str) -> Option<Vec<f64>> {
        self.value(name)?.as_array()?.iter().map(Value::as_f64).collect()
    }

    /// Returns the object in the member `name`; `None` if the member is missing or no object.
    pub fn child(&self, name: &str) -> Option<Self> {
        self.value(name)?.as_object().map(|members| self.nested(members, name))
    }

    /// Returns the object with these `members`, whose place is `name` inside this object.
    pub fn nested(&self, members: &'a Map<String, Value>, name: &str) -> Self {
        let place = if self.place.is_empty() { name.to_owned() } else { format!("{}.{name}", self.place) };
        Self::new(self.file, self.record, members, place)
    }

    /// Returns the objects in the list `name`; empty if the member is missing.
    ///
    /// # Errors
    /// If the member is no list, or if an entry is no object.
    pub fn children(&self, name: &str) -> ReadResult<Vec<Self>> {
        let Some(value) = self.value(name) else { return Ok(Vec::new()) };
        let entries = value.as_array().ok_or_else(|| self.type_error(name, "a list"))?;
        let object = |(i, entry): (usize, &'a Value)| {
            let members = entry.as_object().ok_or_else(|| self.type_error(&format!("{name}[{i}]"), "an object"))?;
            Ok(self.nested(members, &format!("{name}[{i}]")))
        };
        entries.iter().enumerate().map(object).collect()
    }
}

/// Returns a JSON value as a vector. One number stands for three equal components.
pub(super) fn vector_of(value: &Value) -> Option<DVec3> {
    if let Some(number) = value.as_f64() {
        return Some(DVec3::splat(number));
    }
    match &value.as_array()?[..] {
        [x, y, z] => Some(DVec3::new(x.as_f64()?, y.as_f64()?, z.as_f64()?)),
        _ => None,
    }
}
