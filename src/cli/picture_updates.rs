//! Picture files that are rewritten during a render.

use super::progress::print_message;
use crate::image::{self, Image, WriteOptions};
use crate::render::Film;
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Shortest time between two updates of the picture files, in units of the time that the last
/// update took. So updates take at most 1 % of a render.
const MIN_INTERVAL_UPDATE_RATIO: u32 = 100;

/// Writer of the pictures of an unfinished render.
///
/// Readers never see half a file: [`image::write`] writes another file and renames it.
pub(super) struct PictureUpdater<'a> {
    paths: &'a [PathBuf],
    options: &'a WriteOptions,
    interval: Duration,
    /// Earliest time of the next update; `None` before the first update.
    next_update: Option<Instant>,
    /// True after a file could not be written. No further updates follow.
    failed: bool,
}

impl<'a> PictureUpdater<'a> {
    /// Makes a writer that updates the pictures at `paths` after the first pass, and then at most
    /// once per `interval`.
    pub fn new(paths: &'a [PathBuf], options: &'a WriteOptions, interval: Duration) -> Self {
        Self { paths, options, interval, next_update: None, failed: false }
    }

    /// Writes the picture of `film`, which is the mean of all passes so far, if an update is due.
    ///
    /// After an error, prints a warning and makes no more updates. The render goes on, because the
    /// file may be writable again when the render ends.
    pub fn update_if_due(&mut self, film: &Film) {
        let start = Instant::now();
        if self.failed || self.next_update.is_some_and(|next| start < next) {
            return;
        }
        if let Err(error) = self.write(film) {
            print_message(&format!("warning: no picture is written before the end of the render: {error}"));
            self.failed = true;
        }
        let now = Instant::now();
        self.next_update = Some(now + self.interval.max((now - start) * MIN_INTERVAL_UPDATE_RATIO));
    }

    /// Writes the picture of `film`, the mean of its passes, to all paths.
    fn write(&self, film: &Film) -> Result<(), Box<dyn Error>> {
        let (width, height) = film.size();
        let picture = Image::from_pixels(width, height, film.mean_picture())?;
        for path in self.paths {
            image::write(path, &picture, self.options)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn film(radiance: f32) -> Film {
        let mut film = Film::new(1, 1);
        film.add(&[Vec3::splat(radiance)]);
        film
    }

    #[test]
    fn pictures_are_rewritten_once_per_interval() {
        let folder = tempfile::tempdir().unwrap();
        let (path, options) = (folder.path().join("a.exr"), WriteOptions::default());
        let red = || image::read(&path).unwrap().pixels()[0].x;
        let mut updates = PictureUpdater::new(std::slice::from_ref(&path), &options, Duration::from_secs(1000));
        updates.update_if_due(&film(1.0));
        assert_eq!(red(), 1.0);
        updates.update_if_due(&film(2.0));
        assert_eq!(red(), 1.0);
        updates.next_update = Some(Instant::now());
        updates.update_if_due(&film(3.0));
        assert_eq!(red(), 3.0);
        assert!(updates.next_update.unwrap() > Instant::now() + Duration::from_secs(900));
    }

    #[test]
    fn updates_end_after_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let (path, options) = (folder.path().join("later/a.exr"), WriteOptions::default());
        let mut updates = PictureUpdater::new(std::slice::from_ref(&path), &options, Duration::ZERO);
        updates.update_if_due(&film(1.0));
        std::fs::create_dir(folder.path().join("later")).unwrap();
        updates.next_update = None;
        updates.update_if_due(&film(1.0));
        assert!(!path.exists());
    }
}
