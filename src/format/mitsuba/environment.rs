//! Converts environment maps of Mitsuba.

use super::context::ImportContext;
use super::files::ReadResult;
use super::textures::MitsubaTextures;
use super::tree::MitsubaObject;
use crate::format::description::{EnvironmentRadiance, Span, Spanned};
use crate::format::imported_environment::place_environment_map;
use glam::{DMat3, DMat4, Vec3};

/// Returns the radiance of an `envmap` emitter, with its map embedded as a picture.
///
/// Resamples the map if its transform is not a rotation about y. Negative channels become 0, and
/// pixels that are not finite become black.
pub(super) fn read_environment(
    context: &ImportContext<'_>,
    textures: &mut MitsubaTextures,
    emitter: &MitsubaObject,
    to_world: DMat4,
) -> ReadResult<EnvironmentRadiance> {
    let (file, image) = textures.decode_picture_file(context, emitter, false)?;
    let scale = emitter.number("scale").unwrap_or(1.0);
    if !(0.0..=1e30).contains(&scale) {
        return Err(emitter.place.error("the scale of the environment map is negative", "correct `scale`"));
    }
    context.files.check_memory(&file, 24 * image.pixels().len() as u64)?;
    let mut image = (*image).clone();
    for pixel in image.pixels_mut() {
        *pixel = if pixel.is_finite() { pixel.max(Vec3::ZERO) } else { Vec3::ZERO };
    }
    let placed = place_environment_map(image, DMat3::from_mat4(to_world));
    let singular = || emitter.place.error("the transform of the environment map is singular", "scale it less");
    let (image, rotate) = placed.ok_or_else(singular)?;
    let path = Spanned::new(textures.embed_picture(image), Span::default());
    Ok(EnvironmentRadiance::Picture { path, scale, rotate })
}
