//! Reference pictures of a study: two pictures with independent noise, or one that is taken as
//! exact.

use super::Reference;
use super::clock::{measure_time, system_clock};
use crate::image::metrics::{MetricError, rmse};
use crate::image::{Image, PictureSizeError, RelativeErrorWeights, open_file};
use crate::integrate::{Algorithm, CameraPathSettings, ProgressMonitor, Settings};
use crate::plan::{EffectOverrides, Plan};
use crate::render::Film;
use crate::scene::{Effect, Scene};
use glam::DVec3;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Numbers that are added to the study's first seed to get the seeds of the two references. The
/// numbers are so large that no compared method uses the same seeds.
const SEED_OFFSETS: [u64; 2] = [1 << 62, 1 << 63];

/// First bytes of every PNG file.
const PNG_SIGNATURE: [u8; 4] = *b"\x89PNG";

/// Reason why reference pictures cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A reference file cannot be read.
    #[error(transparent)]
    Read(#[from] crate::image::ReadError),
    /// Both reference files hold the same picture, so their noise is not independent.
    #[error("`{}` equals the other reference, so its noise would count as bias: render it with another seed", path.display())]
    EqualPictures {
        /// Path of the second reference file.
        path: PathBuf,
    },
    /// The reference file is a PNG. Its pixels are clipped and rounded, so errors cannot be
    /// measured.
    #[error("`{}` is a PNG, which is clipped and rounded: use OpenEXR or Radiance HDR", path.display())]
    NotLinear {
        /// Path of the reference file.
        path: PathBuf,
    },
    /// The size of the reference differs from the size of the study.
    #[error(
        "`{}` has {} × {} pixels, but the study {} × {}: give --size {}x{}, or a reference of the study's size",
        path.display(), found.0, found.1, wanted.0, wanted.1, found.0, found.1
    )]
    SizeMismatch {
        /// Path of the reference file.
        path: PathBuf,
        /// Width and height of the reference \[pixels].
        found: (u32, u32),
        /// Width and height of the study's pictures \[pixels].
        wanted: (u32, u32),
    },
    /// A pixel of a reference is not finite, or the references differ in size.
    #[error("the references cannot be used: {0}")]
    Metric(#[from] MetricError),
    /// The size of a reference picture is not allowed.
    #[error(transparent)]
    InvalidSize(#[from] PictureSizeError),
}

/// Two reference pictures of equal size with independent noise, or one that is taken as exact.
#[derive(Clone, Debug)]
pub struct ReferencePictures {
    source: String,
    error: Option<f64>,
    pair: [Image; 2],
    mean: Image,
    relative_error_weights: RelativeErrorWeights,
}

impl ReferencePictures {
    /// Makes reference pictures from `a` and `b`. Without `b`, `a` is taken as exact.
    ///
    /// `source` is a text that reports show: it says where the pictures come from.
    ///
    /// # Errors
    /// [`ReferenceError::Metric`] if sizes differ or a pixel is not finite.
    pub fn new(source: String, a: Image, b: Option<Image>) -> Result<Self, ReferenceError> {
        let exact = b.is_none();
        let b = b.unwrap_or_else(|| a.clone());
        // `rmse` is called because it checks sizes and pixels. Its value is not used.
        rmse(&a, &b)?;
        let mean_pixels =
            a.pixels().iter().zip(b.pixels()).map(|(a, b)| ((a.as_dvec3() + b.as_dvec3()) * 0.5).as_vec3());
        let mean = Image::from_pixels(a.width(), a.height(), mean_pixels.collect())?;
        let scale = RelativeErrorWeights::from_image(&mean);
        let squared_difference = |i: usize| (a.pixels()[i].as_dvec3() - b.pixels()[i].as_dvec3()).map(|d| d * d);
        let error = (!exact).then(|| 0.5 * scale.mean_relative_squared_error(squared_difference).sqrt());
        Ok(Self { source, error, pair: [a, b], mean, relative_error_weights: scale })
    }

    /// Reads one or two reference pictures, whose width and height must be `size` \[pixels].
    ///
    /// # Errors
    /// [`ReferenceError`] if a file cannot be read, is a PNG, has another size or a pixel that is
    /// not finite, or if both pictures are equal.
    pub fn read(first: &Path, second: Option<&Path>, size: (u32, u32)) -> Result<Self, ReferenceError> {
        let source = match second {
            Some(second) => format!("{}, {}", first.display(), second.display()),
            None => format!("{}, taken as exact", first.display()),
        };
        let (a, b) = (read_reference(first, size)?, second.map(|path| read_reference(path, size)).transpose()?);
        match second {
            Some(second) if b.as_ref() == Some(&a) => Err(ReferenceError::EqualPictures { path: second.to_owned() }),
            _ => Self::new(source, a, b),
        }
    }

    /// Renders two references of `scene` with different seeds, by the algorithm that
    /// [`reference_algorithm`] chooses. Returns `None` if `interrupted` becomes true.
    ///
    /// Camera paths have the settings `base_settings`, except for two: the number of camera rays is
    /// the default, and adaptive sampling is off. Both references get equally many passes, at least
    /// one. Rendering ends when the processor time per reference reaches `seconds` \[s]. After each
    /// pass, calls `after` with the number of passes and the fraction of `seconds` that has been
    /// used.
    ///
    /// # Errors
    /// [`ReferenceError`] if a pixel is not finite.
    pub fn render(
        scene: &Scene,
        base_settings: &CameraPathSettings,
        seconds: f64,
        interrupted: &AtomicBool,
        monitor: &dyn ProgressMonitor,
        mut after: impl FnMut(u32, f64),
    ) -> Result<Option<Self>, ReferenceError> {
        let (algorithm, why) = reference_algorithm(scene, base_settings.effects);
        let clock = system_clock();
        let (width, height) = scene.camera().size();
        let prepare = |seed_offset| {
            let camera_paths = CameraPathSettings {
                seed: base_settings.seed.wrapping_add(seed_offset),
                samples_per_pixel: None,
                adaptive: false,
                ..base_settings.clone()
            };
            algorithm.prepare(scene, Settings { camera_paths, ..Settings::default() })
        };
        let integrators = SEED_OFFSETS.map(prepare);
        let mut films = [Film::new(width, height), Film::new(width, height)];
        let mut spent = 0.0;
        while films[0].passes() == 0 || spent < 2.0 * seconds {
            if interrupted.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let ((), time) = measure_time(&clock, || {
                for (integrator, film) in integrators.iter().zip(&mut films) {
                    film.add(&integrator.render_pass(film.passes(), monitor).image);
                }
            });
            spent += time.cpu_seconds;
            after(films[0].passes(), spent / (2.0 * seconds));
        }
        let n = films[0].passes();
        let passes = if n == 1 { "pass" } else { "passes" };
        let source = format!("auto: {n} {passes} of {}, twice: {why}", algorithm.name());
        let [a, b] = films.map(|film| Image::from_pixels(width, height, film.mean_picture()));
        Self::new(source, a?, Some(b?)).map(Some)
    }

    /// Returns the two reference pictures. They are equal if a single reference is taken as exact.
    #[must_use]
    pub fn both_reference_pictures(&self) -> &[Image; 2] {
        &self.pair
    }

    /// Returns the mean of both references, with its origin and relative error. Errors of methods
    /// are measured against this mean.
    ///
    /// For the references A and B, the error is the noise of the mean: ½√(mean of (A − B)²), with
    /// the weights of relative errors. This noise does not show a bias that both references share.
    /// The error is `None` for a single reference, which is taken as exact.
    #[must_use]
    pub fn mean_reference(&self) -> Reference {
        Reference { source: self.source.clone(), error: self.error, picture: self.mean.clone() }
    }

    /// Returns the mean of the two reference pictures, or the single reference picture.
    pub(super) fn mean(&self) -> &Image {
        &self.mean
    }

    /// Returns the weights that turn squared errors of pixels into relative ones. They are made
    /// from the mean of both references.
    pub(super) fn relative_error_weights(&self) -> &RelativeErrorWeights {
        &self.relative_error_weights
    }

    /// Returns an unbiased estimate of the squared error of the radiance `value` in pixel `i`,
    /// summed over channels.
    ///
    /// The estimate is (I − A)(I − B) for the radiance I and the references A and B. The noise of A
    /// is independent of the noise of B, so both cancel in the mean over many pixels.
    pub(super) fn unbiased_squared_error(&self, i: usize, value: DVec3) -> f64 {
        let [a, b] = self.pair.each_ref().map(|image| image.pixels()[i].as_dvec3());
        ((value - a) * (value - b)).element_sum()
    }
}

fn read_reference(path: &Path, wanted: (u32, u32)) -> Result<Image, ReferenceError> {
    let mut start = [0; PNG_SIGNATURE.len()];
    if open_file(path).and_then(|(mut file, _)| file.read_exact(&mut start)).is_ok() && start == PNG_SIGNATURE {
        return Err(ReferenceError::NotLinear { path: path.to_owned() });
    }
    let image = crate::image::read(path)?;
    let found = (image.width(), image.height());
    if found != wanted {
        return Err(ReferenceError::SizeMismatch { path: path.to_owned(), found, wanted });
    }
    Ok(image)
}

/// Returns the algorithm for rendering references, and the reason for it as text.
///
/// The algorithm is `hybrid` if the scene has caustics to simulate, because `path` may miss them.
/// Else the algorithm is `path`.
#[must_use]
pub fn reference_algorithm(scene: &Scene, overrides: EffectOverrides) -> (Algorithm, &'static str) {
    let plan = Plan::new(scene, Algorithm::Hybrid.supported_effects(), overrides);
    if plan.simulated_effects().has(Effect::Caustics) {
        (Algorithm::Hybrid, "unbiased except caustics, whose blur shrinks")
    } else {
        (Algorithm::Path, "unbiased, and the scene has no caustics")
    }
}
