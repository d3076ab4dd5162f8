//! The block `GoniometricLight` of the scene language: a point light with a measured intensity in
//! each direction.

use super::LightBlock;
use super::delta::{PATTERN_STRENGTH, PointLightStrength, add_delta_light};
use super::oriented::{LightPose, POSE_FIELDS};
use crate::color::Rgb;
use crate::format::error::SceneError;
use crate::format::language::field_table::{BlockCodec, FieldEntry};
use crate::format::language::fields::BlockFields;
use crate::format::language::schema::{BlockSchema, FieldKind, block_schema, field_schema};
use crate::format::language::writer::SceneWriter;
use crate::format::resolve::Resolver;
use crate::format::span::{Span, Spanned};
use crate::image::PixelMeaning;
use crate::light::{EquirectangularMap, IntensityPattern, OrientedPointLight, map_from_intensity_profile};
use crate::math::Motion;
use crate::scene::UnscaledDeltaLight;
use std::fmt;
use std::sync::Arc;

/// A point light with a measured intensity in each direction.
#[derive(Clone, Debug, PartialEq)]
pub struct GoniometricLightDescription {
    /// Position and orientation of the light.
    pub pose: LightPose,
    /// Intensity in each direction, relative to `strength`.
    pub distribution: IntensityDistribution,
    /// Total flux, or the intensity in those directions where the distribution has the value 1.
    /// [`PointLightStrength::Mit6837Color`] is not allowed.
    pub strength: PointLightStrength,
}

/// Relative intensity of a goniometric light in each direction, read from a file.
///
/// Paths are as written in the scene file: not empty, without line breaks.
#[derive(Clone, Debug, PartialEq)]
pub enum IntensityDistribution {
    /// Path of an equirectangular picture of the intensity in all directions.
    MapFile(Spanned<String>),
    /// Path of a text file that lists the intensity by the angle from the light's axis.
    ProfileFile(Spanned<String>),
}

impl BlockCodec for GoniometricLightDescription {
    fn parse_fields(f: &BlockFields<'_>) -> Result<Self, SceneError> {
        let file = f.require_one_field_of(&["file", "profile"])?;
        let path = file.value();
        let is_map = file.name() == "file";
        let distribution =
            if is_map { IntensityDistribution::MapFile(path) } else { IntensityDistribution::ProfileFile(path) };
        Ok(Self { pose: LightPose::parse(f)?, distribution, strength: PATTERN_STRENGTH.parse(f)? })
    }

    fn write_fields(&self, out: &mut SceneWriter<'_, '_>) -> fmt::Result {
        self.pose.write(out)?;
        match &self.distribution {
            IntensityDistribution::MapFile(path) => out.write_name_field("file", path)?,
            IntensityDistribution::ProfileFile(path) => out.write_name_field("profile", path)?,
        }
        PATTERN_STRENGTH.write(out, &self.strength)
    }
}

impl LightBlock for GoniometricLightDescription {
    const BLOCK: &'static BlockSchema =
        &block_schema("GoniometricLight", "point light with a measured intensity distribution")
            .with_own_fields(&[
                field_schema(
                    "file",
                    FieldKind::Name,
                    "picture of the intensity in all directions, its center along the axis; give this or `profile`",
                ),
                field_schema(
                    "profile",
                    FieldKind::Name,
                    "text file with an angle from the axis in degrees and an intensity per line, in ascending order",
                ),
            ])
            .with_shared_fields(&[POSE_FIELDS, PATTERN_STRENGTH.list.fields]);
    const IS_INFINITE: bool = false;

    fn add(&self, r: &mut Resolver<'_>, motion: &Motion, _: Span) -> Result<(), SceneError> {
        let (direction, up) = self.pose.direction_and_up();
        let (map, direction, up) = match &self.distribution {
            IntensityDistribution::MapFile(path) => {
                let map = EquirectangularMap::new(r.read_picture(path, PixelMeaning::Color)?, Rgb::ONE);
                (map.map_err(|e| r.file_error(path, &e, "repair the picture or name another"))?, direction, up)
            }
            // The map that is made of a profile is symmetric about its up direction. So the up
            // direction must be the light's axis.
            IntensityDistribution::ProfileFile(path) => {
                (read_profile_as_map(r, path)?, direction.any_orthogonal_vector(), direction)
            }
        };
        let pattern = IntensityPattern::Map(Arc::new(map));
        let source = OrientedPointLight { position: self.pose.position, direction, up, pattern };
        add_delta_light(r, UnscaledDeltaLight::Oriented(source), self.strength.resolve(), motion);
        Ok(())
    }

    fn file_path_mut(&mut self) -> Option<&mut String> {
        match &mut self.distribution {
            IntensityDistribution::MapFile(path) | IntensityDistribution::ProfileFile(path) => Some(&mut path.value),
        }
    }
}

/// Largest memory that reading a profile takes \[bytes per byte of its file].
///
/// The text takes 1. The list of pairs takes 4: a pair has 16 bytes in the list, and at least 4
/// bytes in the file. When the list grows, the old list and one of twice its length exist at the
/// same time, so the list counts three times.
const PROFILE_MEMORY_PER_BYTE: u64 = 1 + 3 * 4;

/// Returns the intensity map of the profile in the file `path`.
fn read_profile_as_map(r: &Resolver<'_>, path: &Spanned<String>) -> Result<EquirectangularMap, SceneError> {
    let help = "write an angle from 0 to 180 degrees and an intensity per line, in ascending order";
    let refuse = |message: &str| r.file_error(path, &message, help);
    let file = r.find_file("profile", path)?;
    let size = std::fs::metadata(&file).map_err(|e| refuse(&e.to_string()))?.len();
    if r.memory.available_bytes().is_some_and(|free| PROFILE_MEMORY_PER_BYTE * size > free) {
        return Err(r.file_or_memory_error(path, &"the profile does not fit into memory", true, help));
    }
    let text = std::fs::read_to_string(file).map_err(|e| refuse(&e.to_string()))?;
    let profile = parse_angle_intensity_table(&text).ok_or_else(|| refuse("the profile is not a table of angles"))?;
    map_from_intensity_profile(&profile).map_err(|e| refuse(&e.to_string()))
}

/// Parses an intensity profile: pairs of an angle from the axis \[degrees] and an intensity.
///
/// Each line holds one pair, in ascending order of angle. `#` starts a comment. Lines that are
/// empty or hold only a comment are skipped.
///
/// Returns `None` if any other line is not one pair, or if there are fewer than two pairs. Also
/// returns `None` if the angles do not ascend, or if one is outside \[0, 180].
fn parse_angle_intensity_table(text: &str) -> Option<Vec<(f64, f64)>> {
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let pair = |line: &str| {
        let mut numbers = line.split_whitespace().map(str::parse::<f64>);
        match (numbers.next(), numbers.next(), numbers.next()) {
            (Some(Ok(angle)), Some(Ok(value)), None) => Some((angle, value)),
            _ => None,
        }
    };
    let pairs: Vec<(f64, f64)> = lines.filter(|line| !line.is_empty()).map(pair).collect::<Option<_>>()?;
    let ascending = pairs.windows(2).all(|pair| pair[0].0 < pair[1].0);
    let in_range = pairs.iter().all(|(angle, _)| (0.0..=180.0).contains(angle));
    (pairs.len() >= 2 && ascending && in_range).then_some(pairs)
}
