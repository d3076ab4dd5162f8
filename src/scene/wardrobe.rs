//! What a builder gathers of textures, and what wears them.

use super::builder::SceneBuilder;
use super::movement::MIDDLE;
use super::{BuildError, Dress, Material};
use crate::color::Rgb;
use crate::light::{EmissionTexture, Light};
use crate::math::{Motion, Transform};
use crate::shape::{Form, TextureMapping};
use crate::texture::Texture;
use glam::{DAffine3, DVec2, DVec3, Vec2};
use std::collections::HashMap;
use std::sync::Arc;

/// Where an object stands among those of its sort.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Place {
    Shape(usize),
    MovingShape(usize),
    Plane(usize),
    MovingPlane(usize),
    Part(usize),
}

/// Textures, and what goes by them.
#[derive(Debug, Default)]
pub(super) struct Wardrobe {
    pub textures: Vec<Arc<Texture>>,
    pub dresses: Vec<Dress>,
    /// Of the objects that have one, with the motion of the object.
    charts: Vec<(Form, Motion)>,
    /// Indices of charts, from 1, by their objects.
    chart_of: HashMap<Place, u32>,
    /// Textures and scales of the objects that emit by one.
    glows: HashMap<Place, (u32, Rgb)>,
    /// What was added last.
    pub last: Option<Place>,
    /// Of the corners of meshes.
    pub texcoords: Vec<Vec2>,
}

impl Wardrobe {
    /// The motions of charts around `middle`, where they move, by the index of the chart.
    pub fn motions(&self, middle: DVec3) -> Vec<(usize, Form, Motion)> {
        let back = DAffine3::from_translation(-middle);
        let moving = (1..).zip(&self.charts).filter(|(_, (_, motion))| !motion.is_still());
        moving.map(|(i, (form, motion))| (i, *form, motion.followed_by(back))).collect()
    }

    /// All charts around `middle`; the first is that of what has none of its own.
    pub fn charts(&self, middle: DVec3) -> Result<Vec<TextureMapping>, BuildError> {
        let back = DAffine3::from_translation(-middle);
        let mut charts = vec![TextureMapping::default().translated(-middle)];
        for (form, motion) in &self.charts {
            charts.push(chart_at(*form, &motion.followed_by(back), MIDDLE).ok_or(BuildError::Flattened)?);
        }
        Ok(charts)
    }

    /// Follows its objects where of shapes and planes only those stay that `shapes` and `planes` say.
    pub fn keep(&mut self, shapes: &[bool], planes: &[bool]) {
        let ranks = |stays: &[bool]| -> Vec<Option<usize>> {
            let mut rank = 0..;
            stays.iter().map(|stays| if *stays { rank.next() } else { None }).collect()
        };
        let (shapes, planes) = (ranks(shapes), ranks(planes));
        let place = |place: Place| {
            Some(match place {
                Place::Shape(i) => Place::Shape(shapes[i]?),
                Place::Plane(i) => Place::Plane(planes[i]?),
                other => other,
            })
        };
        self.chart_of = self.chart_of.drain().filter_map(|(at, chart)| Some((place(at)?, chart))).collect();
        self.glows = self.glows.drain().filter_map(|(at, glow)| Some((place(at)?, glow))).collect();
    }

    /// Index of the chart of an object; of several the last counts.
    pub fn chart_of(&self, place: Place) -> u32 {
        self.chart_of.get(&place).copied().unwrap_or(0)
    }

    /// How the light that an object is follows a texture, if it does.
    pub fn glow_of(&self, place: Place, charts: &[TextureMapping]) -> Option<Arc<EmissionTexture>> {
        let (texture, scale) = self.glows.get(&place)?;
        let (texture, chart) = (self.textures[*texture as usize].clone(), charts[self.chart_of(place) as usize]);
        Some(Arc::new(EmissionTexture { texture, mapping: chart, scale: *scale }))
    }

    /// The lights with their mean radiance; none where no light follows a texture.
    pub fn even(&self, lights: &[Light]) -> Vec<Light> {
        if self.glows.is_empty() { Vec::new() } else { lights.iter().map(Light::with_mean_emission).collect() }
    }
}

/// A chart at a time of the motion of its object; `None` where no numbers can hold it.
pub(super) fn chart_at(form: Form, motion: &Motion, time: f64) -> Option<TextureMapping> {
    Some(TextureMapping::new(form, Transform::new(motion.at(time)).ok()?))
}

impl SceneBuilder {
    /// Adds a texture and returns its index.
    pub fn texture(&mut self, texture: Texture) -> u32 {
        self.wardrobe.textures.push(Arc::new(texture));
        self.wardrobe.textures.len() as u32 - 1
    }

    /// Adds a material that wears `dress`, of textures that were added, and returns its index.
    pub fn dressed(&mut self, material: Material, dress: Dress) -> u32 {
        self.wardrobe.dresses.push(dress);
        let dress = Some(self.wardrobe.dresses.len() as u32 - 1);
        self.material(Material { dress, ..material })
    }

    /// Lays texture coordinates after `form` on the object that was added last, which `to_world` places: the space inside it is that of
    /// the form, and of patterns in space. Without, coordinates are the object's own parameters, and the space is the world.
    pub fn chart(&mut self, form: Form, to_world: &Motion) -> &mut Self {
        if let Some(last) = self.wardrobe.last {
            self.wardrobe.charts.push((form, to_world.clone()));
            self.wardrobe.chart_of.insert(last, self.wardrobe.charts.len() as u32);
        }
        self
    }

    /// The emission of the object that was added last, a mean, follows `texture` times `scale` \[W/(m² sr)].
    pub fn glow(&mut self, texture: u32, scale: Rgb) -> &mut Self {
        self.wardrobe.glows.extend(self.wardrobe.last.map(|last| (last, (texture, scale))));
        self
    }

    /// Gives the corners of the mesh that was added last texture coordinates, one each.
    pub fn texcoords(&mut self, texcoords: &[DVec2]) -> &mut Self {
        let before = self.corner_count().saturating_sub(texcoords.len());
        self.wardrobe.texcoords.resize(before, Vec2::ZERO);
        self.wardrobe.texcoords.extend(texcoords.iter().map(|t| t.as_vec2()));
        self
    }
}
