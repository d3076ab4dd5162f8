//! Converts sensors of Mitsuba to cameras.

use super::context::ImportContext;
use super::files::ReadResult;
use super::tree::{MitsubaObject, ObjectClass};
use crate::format::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, LensDescription, ProjectionDescription,
};
use glam::{DMat4, DVec3};

/// Width and height of a film if the file states none \[pixels].
const DEFAULT_FILM_SIZE: [u32; 2] = [768, 576];

/// Diagonal of 35 mm film (24 mm × 36 mm), for which Mitsuba states focal lengths \[mm].
const FULL_FRAME_DIAGONAL_MM: f64 = 43.266_615_305_567_875;

/// Greatest width and height of a picture \[pixels].
const MAX_FILM_SIDE: f64 = 65_536.0;

/// Size of a film, and of the centered part of it (the crop) that is rendered.
struct MitsubaFilm {
    /// Width and height of the film \[pixels].
    size: [f64; 2],
    /// Width and height of the crop, which is the size of the picture \[pixels].
    crop_size: [f64; 2],
}

/// Converts a sensor to a camera; `None` if the kind of sensor is not supported.
///
/// A sensor of Mitsuba looks along +z of its own frame, with +y up and +x to the left.
pub(super) fn read_camera(
    context: &ImportContext<'_>,
    sensor: &MitsubaObject,
) -> ReadResult<Option<CameraDescription>> {
    let film = read_film(context, sensor)?;
    let to_world = sensor.transform("to_world").unwrap_or(DMat4::IDENTITY);
    let axes = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|axis| axis.truncate());
    let determinant = axes[0].dot(axes[1].cross(axes[2]));
    let [Some(_), Some(up), Some(direction)] = axes.map(DVec3::try_normalize) else {
        return Err(sensor.place.error("the transform of the sensor is singular", "scale it by numbers above 0"));
    };
    if determinant == 0.0 || !determinant.is_finite() {
        return Err(sensor.place.error("the transform of the sensor is singular", "scale it by numbers above 0"));
    }
    if determinant < 0.0 {
        context.add_note("sensors that mirror show the scene without mirroring", sensor);
    }
    let projection = match sensor.plugin.as_str() {
        "perspective" | "perspective_rdist" => perspective_projection(context, sensor, &film, None)?,
        "thinlens" => {
            let missing = |name: &str| sensor.place.error(format!("the lens has no `{name}` above 0"), "give it");
            let radius = sensor.number("aperture_radius").filter(|radius| *radius >= 0.0);
            let focus = sensor.number("focus_distance").filter(|distance| *distance > 0.0);
            let lens = LensDescription {
                aperture: ApertureDescription::Radius(radius.ok_or_else(|| missing("aperture_radius"))?),
                focus: FocusDescription::Distance(focus.ok_or_else(|| missing("focus_distance"))?),
                blades: 0,
            };
            perspective_projection(context, sensor, &film, Some(lens))?
        }
        "orthographic" => {
            let size = 2.0 * axes[0].length() * film.size[1] / film.size[0] * (film.crop_size[1] / film.size[1]);
            ProjectionDescription::Orthographic { view_height: size }
        }
        "spherical" => ProjectionDescription::Panorama,
        _ => return Ok(None),
    };
    Ok(Some(CameraDescription {
        center: to_world.w_axis.truncate(),
        aim: DirectionOrTarget::Direction(direction),
        up,
        projection,
        width: film.crop_size[0] as u32,
        height: film.crop_size[1] as u32,
        motion: Vec::new(),
    }))
}

/// Returns the perspective projection of a sensor. A crop of the film narrows the field of view.
fn perspective_projection(
    context: &ImportContext<'_>,
    sensor: &MitsubaObject,
    film: &MitsubaFilm,
    lens: Option<LensDescription>,
) -> ReadResult<ProjectionDescription> {
    let half_height = tan_half_vertical_fov(sensor, film.size)?;
    if ["principal_point_offset_x", "principal_point_offset_y"]
        .iter()
        .any(|name| sensor.number(name).unwrap_or(0.0) != 0.0)
    {
        context.add_note("offsets of the principal point are ignored: the view is centered", sensor);
    }
    let angle = 2.0 * libm::atan(half_height * film.crop_size[1] / film.size[1]).to_degrees();
    Ok(ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens })
}

/// Returns the tangent of half the vertical field of view of a sensor or projector.
///
/// Uses the parameter `fov`, or else `focal_length`, or else 50 mm. `size` is the width and height
/// of the film or projected picture; only their ratio matters.
pub(super) fn tan_half_vertical_fov(sensor: &MitsubaObject, size: [f64; 2]) -> ReadResult<f64> {
    let [width, height] = size;
    let diagonal = libm::hypot(width, height);
    let Some(angle) = sensor.number("fov") else {
        let text = sensor.text("focal_length").unwrap_or("50mm");
        let length = text.trim().trim_end_matches("mm").trim().parse().ok().filter(|mm: &f64| *mm > 0.0);
        let invalid = || sensor.place.error(format!("`{text}` is no focal length"), "write one such as `50mm`");
        return Ok(0.5 * FULL_FRAME_DIAGONAL_MM / length.ok_or_else(invalid)? * height / diagonal);
    };
    if !(angle > 0.0 && angle < 180.0) {
        return Err(sensor.place.error("the field of view is not between 0 and 180 degrees", "correct `fov`"));
    }
    let half = libm::tan(0.5 * angle.to_radians());
    Ok(match sensor.text("fov_axis").unwrap_or("x") {
        "y" => half,
        "diagonal" => half * height / diagonal,
        "smaller" => half * height / width.min(height),
        "larger" => half * height / width.max(height),
        "x" => half * height / width,
        other => {
            let help = "use x, y, diagonal, smaller or larger";
            return Err(sensor.place.error(format!("`{other}` is no axis of a field of view"), help));
        }
    })
}

/// Reads the size of a sensor's film and its crop. A crop off the center is ignored, and a message
/// tells the user.
fn read_film(context: &ImportContext<'_>, sensor: &MitsubaObject) -> ReadResult<MitsubaFilm> {
    let [width, height] = DEFAULT_FILM_SIZE.map(f64::from);
    let Some(film) = context.named_or_unnamed_child(sensor, ObjectClass::Film, "film")? else {
        return Ok(MitsubaFilm { size: [width, height], crop_size: [width, height] });
    };
    let pixels = |name: &str, default: f64| {
        let count = film.number(name).unwrap_or(default).trunc();
        let invalid = || film.place.error(format!("`{name}` is not between 1 and {MAX_FILM_SIDE}"), "correct it");
        if (1.0..=MAX_FILM_SIDE).contains(&count) { Ok(count) } else { Err(invalid()) }
    };
    let size = [pixels("width", width)?, pixels("height", height)?];
    let crop = [pixels("crop_width", size[0])?, pixels("crop_height", size[1])?];
    let offset = ["crop_offset_x", "crop_offset_y"].map(|name| film.number(name).unwrap_or(0.0));
    let is_centered = (0..2).all(|axis| size[axis] - crop[axis] == 2.0 * offset[axis]);
    if is_centered {
        return Ok(MitsubaFilm { size, crop_size: crop });
    }
    context.add_note("crops that are not centered are ignored: the picture shows the whole film", &film);
    Ok(MitsubaFilm { size, crop_size: size })
}
