//! The camera, and where it or a spotlight points.

use glam::DVec3;

use super::super::description::{Aim, Camera};
use super::super::error::SceneError;
use super::super::lexer::Token;
use super::fields::{Fields, Kind};
use super::{Parser, has_direction};

/// Most pixels on a side of the image.
const MAX_SIDE: u32 = 65_536;

impl<'a> Parser<'a> {
    pub fn camera(&mut self, block: Token<'a>) -> Result<Camera, SceneError> {
        let f = self.fields(
            block,
            &[
                ("center", Kind::Vector),
                ("direction", Kind::Vector),
                ("lookAt", Kind::Vector),
                ("up", Kind::Vector),
                ("angle", Kind::Number),
                ("width", Kind::Integer),
                ("height", Kind::Integer),
            ],
        )?;
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
        let angle = f.need("angle")?;
        angle.ensure(angle.number() > 0.0 && angle.number() < 180.0, "must lie between 0 and 180 degrees")?;
        let side = |name, default: u32| match f.get(name) {
            None => Ok(default),
            Some(side) => {
                let pixels = side.number();
                side.ensure(pixels >= 1.0 && pixels <= f64::from(MAX_SIDE), "must lie between 1 and 65536 pixels")?;
                Ok(pixels as u32)
            }
        };
        Ok(Camera { center, aim, up, angle: angle.number(), width: side("width", 960)?, height: side("height", 720)? })
    }
}

impl Fields<'_> {
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
