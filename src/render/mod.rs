//! The render loop: runs passes of an integrator, averages them, and estimates the error of the
//! mean.

mod driver;
pub mod error_estimate;
mod expected_end;
mod film;
mod film_file;
mod layers;
mod limits;
mod memory;
mod merge_error;
mod pass_set;
#[cfg(test)]
mod test_integrator;

pub use driver::{EndReason, ErrorTarget, PassProgress, PassTimes, RenderResult, StopCriteria, render};
pub use expected_end::ExpectedEnd;
pub use film::Film;
pub use film_file::{FilmFile, FilmFileError, FilmHeader, InputDigest, read_film_header, read_pass_numbers};
pub use layers::{picture_layers, rgb_layer, surface_layers};
pub use limits::{DEFAULT_TARGET_ERROR, DEFAULT_TIME_LIMIT, PREVIEW_TARGET_ERROR, RenderLimits};
pub use memory::{
    LayerSelection, MemoryError, check_films_memory, check_layered_picture_memory, check_photon_memory,
    check_picture_and_error_memory, check_picture_memory,
};
pub use merge_error::MergeError;
pub use pass_set::PassSet;

#[cfg(test)]
mod tests;
