//! Reads cameras and films of pbrt scenes.

use super::files::ReadResult;
use super::graphics_state::{MovingTransform, object_motion};
use super::parameters::Parameters;
use crate::format::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, LensDescription, ProjectionDescription,
};
use crate::format::import_notes::ImportNotes;
use glam::{DAffine3, DVec3};

/// Greatest width and height of a picture \[pixels].
const MAX_FILM_SIDE: f64 = 65_536.0;

/// Message about pbrt films that scale radiance by an exposure or a sensor response.
const EXPOSURE_NOTE: &str = "sensors and exposures of films are ignored: pixels are radiance";

/// Size of a pbrt film and of its crop window \[pixels].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FilmSize {
    /// Width and height of the whole film.
    pub whole: [u32; 2],
    /// Width and height of the crop window, the centered part that is rendered.
    pub crop: [u32; 2],
}

impl FilmSize {
    /// Size of a film in pbrt-v4 if the file states none.
    pub const DEFAULT: Self = Self { whole: [1280, 720], crop: [1280, 720] };
}

/// Reads the size of a film of type `name`, such as `rgb`, and of its crop window.
///
/// A crop window off the center is ignored, and a message tells the user.
pub(super) fn film_size(name: &str, parameters: &Parameters, notes: &mut ImportNotes) -> ReadResult<FilmSize> {
    let place = &parameters.place;
    if !matches!(name, "rgb" | "image" | "gbuffer" | "spectral") {
        let message = format!("no film is called `{name}`");
        return Err(place.error(message, "pbrt has the films rgb, gbuffer, spectral and image"));
    }
    let default = if name == "image" { [640.0, 480.0] } else { [1280.0, 720.0] };
    let width = parameters.number_or("xresolution", default[0]);
    let height = parameters.number_or("yresolution", default[1]);
    if !(width >= 1.0 && height >= 1.0 && width <= MAX_FILM_SIDE && height <= MAX_FILM_SIDE) {
        return Err(place.error("the film has no pixels, or too many", "give resolutions from 1 to 65536"));
    }
    let whole = [width, height];
    let crop = crop_size(parameters, whole);
    if crop.is_none() {
        notes.add_unsupported(
            "crop windows off the center are ignored: the whole picture is rendered",
            place.position_text(),
        );
    }
    let gain = parameters.number_or("iso", 100.0) / 100.0 * parameters.number_or("exposuretime", 1.0);
    let is_physical = parameters.text("sensor").is_some_and(|sensor| sensor != "cie1931");
    if is_physical || gain != 1.0 || parameters.number_or("scale", 1.0) != 1.0 {
        notes.add_unsupported(EXPOSURE_NOTE, place.position_text());
    }
    if parameters.number_or("whitebalance", 0.0) != 0.0 {
        notes.add_unsupported("white balances of films are ignored", place.position_text());
    }
    Ok(FilmSize { whole: whole.map(|side| side as u32), crop: crop.unwrap_or(whole).map(|side| side as u32) })
}

/// Returns the times at which the shutter of a camera opens and closes, the earlier one first.
pub(super) fn shutter_times(parameters: &Parameters) -> [f64; 2] {
    let [open, close] = [parameters.number_or("shutteropen", 0.0), parameters.number_or("shutterclose", 1.0)];
    [open.min(close), open.max(close)]
}

/// Adds a message unless the exposure time of a camera is 1. This is the time for which its shutter
/// is open.
///
/// pbrt-v4 multiplies pixels by the exposure time, and Caustica does not.
pub(super) fn note_exposure_time(parameters: &Parameters, notes: &mut ImportNotes) {
    let [open, close] = shutter_times(parameters);
    if (close - open - 1.0).abs() > 1e-6 {
        notes.add_unsupported(EXPOSURE_NOTE, parameters.place.position_text());
    }
}

/// Returns the size of the crop window; the size of the film if there is none \[pixels].
///
/// `None` if the window is empty, or if its center is more than half a pixel off the film's center.
fn crop_size(parameters: &Parameters, whole: [f64; 2]) -> Option<[f64; 2]> {
    let bounds = match (parameters.numbers("pixelbounds"), parameters.numbers("cropwindow")) {
        ([x0, x1, y0, y1], _) => [[*x0, *x1], [*y0, *y1]],
        (_, [x0, x1, y0, y1]) => {
            let pixels = |part: &f64, side: f64| (part * side).ceil();
            [[pixels(x0, whole[0]), pixels(x1, whole[0])], [pixels(y0, whole[1]), pixels(y1, whole[1])]]
        }
        _ => return Some(whole),
    };
    let mut size = [0.0; 2];
    for axis in 0..2 {
        let [low, high] = bounds[axis].map(|pixel| pixel.clamp(0.0, whole[axis]).round());
        if high <= low || (low + high - whole[axis]).abs() > 1.0 {
            return None;
        }
        size[axis] = high - low;
    }
    Some(size)
}

/// Returns the camera, and the map from pbrt's world to the imported scene: a reflection along z,
/// or the identity.
///
/// `to_world` maps camera space to pbrt's world. pbrt's camera space is left-handed, and Caustica's
/// is right-handed. So the scene is mirrored, unless `to_world` already mirrors.
///
/// The pictures of spherical cameras have equal handedness in pbrt and Caustica. For such a camera,
/// the scene is mirrored only if `to_world` mirrors.
pub(super) fn read_camera(
    name: &str,
    parameters: &Parameters,
    to_world: MovingTransform,
    film: FilmSize,
    notes: &mut ImportNotes,
) -> ReadResult<(CameraDescription, DAffine3)> {
    let place = &parameters.place;
    let [width, height] = film.whole;
    let [to_world, at_end] = to_world.0;
    let axes = to_world.matrix3;
    let lengths = [axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length()];
    let scale = lengths[2];
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let is_even = lengths.iter().all(|length| (length / scale - 1.0).abs() < 1e-4)
        && x.dot(y).abs() + y.dot(z).abs() + z.dot(x).abs() < 1e-4 * scale * scale;
    if !is_even {
        notes.add_unsupported("cameras that are sheared or stretched are not", place.position_text());
    }
    let is_spherical = matches!(name, "spherical" | "environment");
    // The pictures of spherical cameras have equal handedness in pbrt and Caustica.
    let needs_mirror = (axes.determinant() > 0.0) != is_spherical;
    let mirror = if needs_mirror { DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)) } else { DAffine3::IDENTITY };
    let placed = mirror * to_world;
    let motion = object_motion(&MovingTransform([placed, mirror * at_end]));
    if motion.as_ref().is_some_and(|motion| motion.omits_deformation) {
        notes.add_unsupported("cameras whose scale changes over the shutter only move and turn", place.position_text());
    }
    let aspect = parameters.number("frameaspectratio").unwrap_or(f64::from(width) / f64::from(height));
    let aspect = if aspect > 0.0 { aspect } else { 1.0 };
    let window = match *parameters.numbers("screenwindow") {
        [left, right, bottom, top] if right > left && top > bottom => [left, right, bottom, top],
        [] if aspect > 1.0 => [-aspect, aspect, -1.0, 1.0],
        [] => [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect],
        _ => return Err(place.error("the screen window is empty", "give `screenwindow` as left, right, bottom, top")),
    };
    let [left, right, bottom, top] = window;
    let is_centered = (left + right).abs() + (bottom + top).abs() < 1e-6 * (top - bottom);
    let is_square = ((right - left) * f64::from(height) / ((top - bottom) * f64::from(width)) - 1.0).abs() < 1e-3;
    if !(is_centered && is_square) {
        let message = "screen windows off the center, and pixels that are not square, are centered and square";
        notes.add_unsupported(message, place.position_text());
    }
    let half_height = 0.5 * (top - bottom) * f64::from(film.crop[1]) / f64::from(height);
    let projection = match name {
        "perspective" => {
            let fov = parameters.number("halffov").map_or(parameters.number_or("fov", 90.0), |half| 2.0 * half);
            if !(fov > 0.0 && fov < 180.0) {
                return Err(place.error("the field of view is not between 0° and 180°", "correct `fov`"));
            }
            let half = libm::atan(libm::tan((0.5 * fov).to_radians()) * half_height);
            let radius = parameters.number_or("lensradius", 0.0) * scale;
            let distance = parameters.number_or("focaldistance", 1e6) * scale;
            let lens = (radius > 0.0 && distance > 0.0).then_some(LensDescription {
                aperture: ApertureDescription::Radius(radius),
                focus: FocusDescription::Distance(distance),
                blades: 0,
            });
            ProjectionDescription::Perspective { vertical_fov_degrees: 2.0 * half.to_degrees(), lens }
        }
        "orthographic" => {
            if parameters.number_or("lensradius", 0.0) > 0.0 {
                notes.add_unsupported("lenses of orthographic cameras are ignored", place.position_text());
            }
            ProjectionDescription::Orthographic { view_height: 2.0 * half_height * scale }
        }
        "spherical" | "environment" => {
            if parameters.text("mapping") != Some("equirectangular") && name == "spherical" {
                let message = "spherical cameras of equal area have an equirectangular picture";
                notes.add_unsupported(message, place.position_text());
            }
            if film.crop != film.whole {
                notes.add_unsupported("crop windows of spherical cameras show all directions", place.position_text());
            }
            ProjectionDescription::Panorama
        }
        _ => {
            let message = format!("no camera `{name}` is supported");
            return Err(place.error(message, "use a perspective, orthographic or spherical camera"));
        }
    };
    let forward = if is_spherical { DVec3::NEG_X } else { DVec3::Z };
    let camera = CameraDescription {
        center: placed.translation,
        aim: DirectionOrTarget::Direction(placed.transform_vector3(forward).normalize()),
        up: placed.transform_vector3(DVec3::Y).normalize(),
        projection,
        width: film.crop[0],
        height: film.crop[1],
        motion: motion.map_or(Vec::new(), |motion| motion.steps),
    };
    Ok((camera, mirror))
}
