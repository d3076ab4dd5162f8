//! Turntable frames of `--frames`: cameras on a circle, and names of output files.

use super::pivot::pivot;
use crate::camera::Camera;
use crate::format::description::{CameraDescription, DirectionOrTarget};
use crate::scene::Scene;
use glam::DVec3;
use std::f64::consts::TAU;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Largest allowed `end` of a [`FrameRange`]. Limits the number of output files, because all of
/// them are checked before the first frame is rendered.
const MAX_FRAME_END: u32 = 10_000;

/// Range of frame numbers to render: value of `--frames`. `0..48` means the frames 0 to 47.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// Number of the first frame to render.
    pub first: u32,
    /// Number of the last frame to render, plus 1.
    pub end: u32,
}

impl FrameRange {
    /// Returns the frame numbers as a range.
    pub(super) fn numbers(self) -> Range<u32> {
        self.first..self.end
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        match numbers {
            Some((first, end)) if first < end && end <= MAX_FRAME_END => Ok(Self { first, end }),
            Some((first, end)) if first < end => Err(format!("`{text}` exceeds frame {MAX_FRAME_END}")),
            Some(_) => Err(format!("`{text}` has no frames: write 0..48 for the frames 0 to 47")),
            None => Err(format!("`{text}` is no range of frames: write 0..48 for the frames 0 to 47")),
        }
    }
}

/// Error: the name of an output file has no place for the frame number, or several. It must contain
/// `%d` or `%04d` once.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{flag} `{}` has no single place for the number of a frame", path.display())]
#[diagnostic(help("write %04d where the number is to stand, such as frame-%04d.png"))]
pub(super) struct FrameNameError {
    flag: &'static str,
    path: PathBuf,
}

/// Error: the camera of a turntable moves while the shutter is open.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("--frames cannot move a camera that moves while the shutter is open")]
#[diagnostic(help("remove Moving around the camera"))]
pub(super) struct MovingTurntableCameraError;

/// Returns `path` with the number `frame` in place of `%d`, or of `%0Nd` with leading zeros up to N
/// digits (1 to 9).
///
/// Returns an error if `path` has no such place, or more than one. The error names `flag`, the flag
/// of the output file.
pub(super) fn frame_path(flag: &'static str, path: &Path, frame: u32) -> Result<PathBuf, FrameNameError> {
    let numbered = path.to_str().and_then(|text| {
        let (before, rest) = text.split_once('%')?;
        let (width, after) = rest.split_once('d')?;
        let digits = match width.strip_prefix('0') {
            Some(digits) => digits.parse().ok().filter(|digits| (1..=9).contains(digits))?,
            None if width.is_empty() => 1,
            None => return None,
        };
        (!after.contains('%')).then(|| format!("{before}{frame:0digits$}{after}").into())
    });
    numbered.ok_or_else(|| FrameNameError { flag, path: path.to_owned() })
}

/// Cameras of a turntable: the scene's camera, turned about an axis through the point `pivot`. All
/// these cameras look at `pivot`.
pub(super) struct Turntable {
    /// Camera of frame 0, in the coordinates of the scene description.
    initial_camera: Camera,
    pivot: DVec3,
    /// Direction of the axis about which the camera turns: the up vector of the scene's camera, as
    /// a unit vector.
    axis: DVec3,
    /// Number of frames of a full turn.
    frames_per_turn: u32,
}

impl Turntable {
    /// Makes the turntable of a scene, whose camera makes a full turn in `frames` frames.
    ///
    /// If the scene names a point that the camera looks at, the camera turns about that point. If
    /// the scene gives a viewing direction instead, the camera turns about the surface point
    /// [`pivot`].
    pub fn new(
        scene: &Scene,
        description: &CameraDescription,
        frames: u32,
    ) -> Result<Self, MovingTurntableCameraError> {
        if !description.motion.is_empty() {
            return Err(MovingTurntableCameraError);
        }
        let pivot = match description.aim {
            DirectionOrTarget::Target(point) => point,
            DirectionOrTarget::Direction(_) => pivot(scene),
        };
        let axis = description.up.normalize_or_zero();
        Ok(Self { initial_camera: scene.camera_in_description(), pivot, axis, frames_per_turn: frames })
    }

    /// Returns the camera of a frame. As frame numbers rise, the camera moves to the right. Returns
    /// `None` for frame 0 and after each full turn: these frames have the camera of the scene.
    pub fn camera(&self, frame: u32) -> Option<Camera> {
        let step = frame % self.frames_per_turn;
        let angle = TAU * f64::from(step) / f64::from(self.frames_per_turn);
        (step > 0).then(|| self.initial_camera.orbited(self.pivot, self.axis, angle, 0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_paths_contain_the_frame_number() {
        let name =
            |path: &str, frame| frame_path("-o", Path::new(path), frame).ok().map(|path| path.display().to_string());
        assert_eq!(name("a/%04d.png", 7), Some("a/0007.png".to_owned()));
        assert_eq!(name("turn-%d.exr", 12), Some("turn-12.exr".to_owned()));
        assert_eq!(name("%02d/a.png", 123), Some("123/a.png".to_owned()));
        for wrong in ["a.png", "%04d-%04d.png", "%4d.png", "%x.png", "%00d.png", "%012d.png", "100%.png"] {
            assert_eq!(name(wrong, 0), None, "{wrong}");
        }
    }

    #[test]
    fn frame_ranges_exclude_their_end() {
        assert_eq!("3..48".parse(), Ok(FrameRange { first: 3, end: 48 }));
        for wrong in ["", "48", "4..4", "5..4", "-1..4", "0..99999", "0...4", "a..b"] {
            assert!(wrong.parse::<FrameRange>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn turntable_cameras_circle_and_face_the_pivot() {
        let camera = Camera::perspective(DVec3::new(1.0, 2.0, 7.0), -DVec3::Z, DVec3::Y, 0.7, 32, 24).unwrap();
        let turntable =
            Turntable { initial_camera: camera, pivot: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::Y, frames_per_turn: 4 };
        assert_eq!((turntable.camera(0), turntable.camera(8)), (None, None));
        for (frame, center) in [(1, (5.0, 3.0)), (2, (1.0, -1.0)), (3, (-3.0, 3.0)), (5, (5.0, 3.0))] {
            let turned = turntable.camera(frame).unwrap();
            let center = DVec3::new(center.0, 2.0, center.1);
            assert!((turned.center() - center).length() < 1e-12, "{frame}: {}", turned.center());
            assert!((turned.forward() * 4.0 - (turntable.pivot - center)).length() < 1e-12, "{frame}");
        }
    }
}
