//! Converts cameras of Tungsten.

use super::context::ImportContext;
use super::object::{ReadResult, TungstenObject};
use super::transforms::read_transform;
use crate::format::description::{
    ApertureDescription, CameraDescription, DirectionOrTarget, FocusDescription, LensDescription, ProjectionDescription,
};
use glam::DAffine3;

/// Width and height of a picture if the file states none \[pixels].
const DEFAULT_RESOLUTION: [f64; 2] = [1000.0, 563.0];

/// Greatest width and height of a picture \[pixels].
const MAX_SIDE: f64 = 65_536.0;

/// Horizontal field of view if the file states none \[degrees].
const DEFAULT_FIELD_OF_VIEW: f64 = 60.0;

/// Greatest distance and size of a lens.
const MAX_LENGTH: f64 = 1e12;

/// Greatest number of blades of a diaphragm.
const MAX_BLADES: f64 = 64.0;

/// Converts the camera of the scene.
///
/// A camera of Tungsten looks along +z of its own frame, with +y up. A camera of unknown kind
/// becomes a pinhole camera, and a message tells the user.
pub(super) fn read_camera(context: &ImportContext<'_>, camera: &TungstenObject<'_>) -> ReadResult<CameraDescription> {
    let [width, height] = read_resolution(camera)?;
    let transform = read_transform(camera)?;
    let direction = transform.matrix3.z_axis.try_normalize();
    let up = transform.matrix3.y_axis.try_normalize();
    let (Some(direction), Some(up)) = (direction, up) else {
        return Err(camera.error("the transform of the camera is singular", "scale it by numbers above 0"));
    };
    if direction.cross(up).length() < 1e-9 {
        return Err(camera.error("the camera looks along its `up`", "correct the transform of the camera"));
    }
    if transform.matrix3.determinant() < 0.0 {
        context.add_note("cameras that mirror show the scene without mirroring", camera);
    }
    let projection = match camera.kind()? {
        "pinhole" => perspective(camera, [width, height], None)?,
        "thinlens" => {
            let lens = read_lens(context, camera, &transform)?;
            perspective(camera, [width, height], Some(lens))?
        }
        kind @ ("equirectangular" | "cubemap") => {
            let message = format!("cameras of kind `{kind}` show an equirectangular panorama about their direction");
            context.add_note(&message, camera);
            camera.value("mode");
            ProjectionDescription::Panorama
        }
        other => {
            context.add_note(&format!("cameras of kind `{other}` become pinhole cameras"), camera);
            perspective(camera, [width, height], None)?
        }
    };
    Ok(CameraDescription {
        center: transform.translation,
        aim: DirectionOrTarget::Direction(direction),
        up,
        projection,
        width: width as u32,
        height: height as u32,
        motion: Vec::new(),
    })
}

/// Returns the width and height of the picture \[pixels].
fn read_resolution(camera: &TungstenObject<'_>) -> ReadResult<[f64; 2]> {
    let numbers = match camera.value("resolution") {
        None => DEFAULT_RESOLUTION.to_vec(),
        Some(value) => match value.as_f64() {
            Some(side) => vec![side, side],
            None => camera.number_list("resolution").unwrap_or_default(),
        },
    };
    match numbers[..] {
        [width, height] if [width, height].iter().all(|side| (1.0..=MAX_SIDE).contains(side)) => {
            Ok([width.trunc(), height.trunc()])
        }
        _ => {
            let message = format!("`resolution` is not two numbers from 1 to {MAX_SIDE}");
            Err(camera.error(message, "write the width and height in pixels"))
        }
    }
}

/// Returns the perspective projection of a camera. Its `fov` is horizontal.
fn perspective(
    camera: &TungstenObject<'_>,
    [width, height]: [f64; 2],
    lens: Option<LensDescription>,
) -> ReadResult<ProjectionDescription> {
    let angle = camera.number("fov")?.unwrap_or(DEFAULT_FIELD_OF_VIEW);
    if !(angle > 0.0 && angle < 180.0) {
        return Err(camera.error("the field of view is not between 0 and 180 degrees", "correct `fov`"));
    }
    let half_height = libm::tan(0.5 * angle.to_radians()) * height / width;
    let vertical_fov_degrees = 2.0 * libm::atan(half_height).to_degrees();
    Ok(ProjectionDescription::Perspective { vertical_fov_degrees, lens })
}

/// Reads the lens of a `thinlens` camera with the given `transform`.
fn read_lens(
    context: &ImportContext<'_>,
    camera: &TungstenObject<'_>,
    transform: &DAffine3,
) -> ReadResult<LensDescription> {
    let radius = camera.number_in("aperture_size", 0.001, 0.0..=MAX_LENGTH)?;
    let mut distance = camera.number_in("focus_distance", 1.0, f64::MIN_POSITIVE..=MAX_LENGTH)?;
    if let Some(name) = camera.text("focus_pivot")?.filter(|name| !name.is_empty()) {
        let pivot_distance = match context.primitive(name) {
            Some(pivot) => Some((read_transform(pivot)?.translation - transform.translation).length()),
            None => None,
        };
        match pivot_distance.filter(|distance| *distance > 0.0) {
            Some(to_pivot) => distance = to_pivot,
            None => context.add_note("the `focus_pivot` is no primitive: `focus_distance` counts", camera),
        }
    }
    if camera.number("cateye")?.is_some_and(|cateye| cateye != 0.0) {
        context.add_note("`cateye` is ignored: highlights out of focus keep their shape", camera);
    }
    let mut blades = 0;
    if let Some(aperture) = camera.child("aperture") {
        match aperture.kind()? {
            "disk" => {}
            "blade" => blades = aperture.number_in("blades", 6.0, 3.0..=MAX_BLADES)? as u32,
            other => context.add_whole_object_note(&format!("apertures of kind `{other}` become disks"), &aperture),
        }
    } else if camera.value("aperture").is_some() {
        context.add_note("apertures that are pictures become disks", camera);
    }
    Ok(LensDescription {
        aperture: ApertureDescription::Radius(radius),
        focus: FocusDescription::Distance(distance),
        blades,
    })
}
