//! The camera, and where it or a spotlight points.

use glam::DVec3;

use super::super::description::{Aim, Camera, Focus, Lens, Map, Opening, Projection, Spanned};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{Fields, Kind};
use super::{Parser, has_direction};

/// Most pixels on a side of the image.
const MAX_SIDE: u32 = 65_536;

/// The cameras.
pub(super) const CAMERAS: [&str; 3] = ["PerspectiveCamera", "OrthographicCamera", "EnvironmentCamera"];

/// Height of a sensor of 36 × 24 mm, where the unit is the metre.
const SENSOR_HEIGHT: f64 = 0.024;

impl<'a> Parser<'a> {
    /// A camera that moves.
    pub fn moving_camera(&mut self, keyword: Token<'a>) -> Result<Spanned<Camera>, SceneError> {
        let read = |parser: &mut Self, word: Token<'a>| Ok(Spanned::new(parser.camera(word)?, word.span()));
        let (motion, mut camera) = self.moving(keyword, &CAMERAS, read)?;
        if motion.iter().any(|map| matches!(map, Map::Scale(_) | Map::UniformScale(_))) {
            let message = "a camera cannot grow".to_owned();
            let help = "let it turn and move by Translate and Rotate alone".to_owned();
            return Err(self.lexer.error(keyword.span(), message, "this motion", help));
        }
        camera.value.motion = motion;
        Ok(camera)
    }

    pub fn camera(&mut self, block: Token<'a>) -> Result<Camera, SceneError> {
        use Kind::{Integer, Number, Vector};
        let common = [
            ("center", Vector),
            ("direction", Vector),
            ("lookAt", Vector),
            ("up", Vector),
            ("width", Integer),
            ("height", Integer),
        ];
        let own: &[(&str, Kind)] = match block.text {
            "PerspectiveCamera" => &[
                ("angle", Number),
                ("aperture", Number),
                ("fNumber", Number),
                ("sensorHeight", Number),
                ("focusDistance", Number),
                ("focusAt", Vector),
                ("blades", Integer),
            ],
            "OrthographicCamera" => &[("size", Number)],
            _ => &[],
        };
        let f = self.fields(block, &[&common[..], own].concat())?;
        let center = f.need("center")?.vector();
        let (aim, direction) = f.aim("center", center)?;
        let up = match f.get("up") {
            Some(up) => up.direction()?,
            None => DVec3::Y,
        };
        // Below this sine of their angle the image has no upright left to trust.
        if up.normalize().cross(direction.normalize()).length() < 1e-9 {
            let place = f.get("up").or(f.get("direction")).or(f.get("lookAt"));
            let message = "`up` is parallel to the direction of view".to_owned();
            let help = "give an `up` that points elsewhere, e.g. `up 0 0 1`".to_owned();
            return Err(f.error(place.map_or(block.span(), |p| p.span()), message, "parallel", help));
        }
        let projection = match block.text {
            "PerspectiveCamera" => {
                let angle = f.need("angle")?;
                angle.ensure(angle.number() > 0.0 && angle.number() < 180.0, "must lie between 0 and 180 degrees")?;
                Projection::Perspective { angle: angle.number(), lens: f.lens(center, direction, aim)? }
            }
            "OrthographicCamera" => {
                let size = f.need("size")?;
                size.ensure(size.number() > 0.0 && size.number() <= 1e12, "must lie between 0 and 1e12")?;
                Projection::Orthographic { size: size.number() }
            }
            _ => Projection::Environment,
        };
        let side = |name, default: u32| match f.get(name) {
            None => Ok(default),
            Some(side) => {
                let pixels = side.number();
                side.ensure(pixels >= 1.0 && pixels <= f64::from(MAX_SIDE), "must lie between 1 and 65536 pixels")?;
                Ok(pixels as u32)
            }
        };
        let width = side("width", 960)?;
        // All directions are twice as wide as high.
        let usual = if block.text == "EnvironmentCamera" { width.div_ceil(2) } else { 720 };
        let height = side("height", usual)?;
        Ok(Camera { center, aim, up, projection, width, height, motion: Vec::new() })
    }
}

impl Fields<'_> {
    /// The lens of a camera at `center` that looks along `direction`.
    fn lens(&self, center: DVec3, direction: DVec3, aim: Aim) -> Result<Option<Lens>, SceneError> {
        const OPENINGS: [&str; 2] = ["aperture", "fNumber"];
        let without = |names: &[&str], missing: &str| {
            let first = names.iter().find_map(|name| self.get(name));
            first.map_or(Ok(()), |field| field.ensure(false, &format!("says nothing without {missing}")))
        };
        if OPENINGS.iter().all(|name| self.get(name).is_none()) {
            without(&["sensorHeight", "focusDistance", "focusAt", "blades"], "`aperture` or `fNumber`")?;
            return Ok(None);
        }
        let opening = self.one_of(&OPENINGS)?;
        let opening = if opening.name() == "aperture" {
            without(&["sensorHeight"], "`fNumber`")?;
            opening.ensure(opening.number() >= 0.0, "must not be negative")?;
            Opening::Radius(opening.number())
        } else {
            let sensor = self.get("sensorHeight").map_or(Ok(SENSOR_HEIGHT), |sensor| sensor.positive())?;
            Opening::FNumber { number: opening.positive()?, sensor }
        };
        let before = |point: DVec3| (point - center).dot(direction) > 0.0;
        let focus = match (self.get("focusDistance").or(self.get("focusAt")), aim) {
            (Some(_), _) => {
                let focus = self.one_of(&["focusDistance", "focusAt"])?;
                if focus.name() == "focusDistance" {
                    Focus::Distance(focus.positive()?)
                } else {
                    focus.ensure(before(focus.vector()), "must lie before the camera")?;
                    Focus::Point(focus.vector())
                }
            }
            (None, Aim::LookAt(point)) => Focus::Point(point),
            (None, Aim::Direction(_)) => Focus::Distance(self.need("focusDistance")?.positive()?),
        };
        let blades = match self.get("blades") {
            None => 0,
            Some(blades) => {
                let n = blades.number();
                blades.ensure(
                    n == 0.0 || (3.0..=64.0).contains(&n),
                    "must be 0, for a round opening, or lie between 3 and 64",
                )?;
                n as u32
            }
        };
        Ok(Some(Lens { opening, focus, blades }))
    }

    /// `direction` or `lookAt`, and the direction that it means when seen from `center`, the value of the field `from`.
    pub fn aim(&self, from: &str, center: DVec3) -> Result<(Aim, DVec3), SceneError> {
        let aim = self.one_of(&["direction", "lookAt"])?;
        if aim.name() == "direction" {
            let direction = aim.direction()?;
            return Ok((Aim::Direction(direction), direction));
        }
        let direction = aim.vector() - center;
        aim.ensure(has_direction(direction), &format!("must lie at some distance from `{from}`"))?;
        Ok((Aim::LookAt(aim.vector()), direction))
    }
}
