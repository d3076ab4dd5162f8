//! Renders of several pictures one after another, for `--frames` and `--stereo`.

use crate::cli::interrupt::INTERRUPTED;
use crate::cli::{CommandFailure, Exit};
use std::sync::atomic::Ordering;

/// Calls `render` for each of `pictures`, and returns the exit code of the command.
///
/// A failure or an interruption ends the series early. A picture that cannot be written does not
/// end it: the error is returned after the last picture. If a signal ends the series, the exit code
/// is [`Exit::Interrupted`], even if pictures could not be written.
pub(super) fn render_series<T>(
    pictures: impl IntoIterator<Item = T>,
    mut render: impl FnMut(T) -> Result<Exit, CommandFailure>,
) -> Result<Exit, CommandFailure> {
    let mut reports = Vec::new();
    let mut end = Exit::Success;
    for picture in pictures {
        match render(picture) {
            Ok(Exit::Success) => {}
            Ok(exit) => {
                end = exit;
                break;
            }
            Err(failure) => {
                reports.extend(failure.reports);
                if failure.exit != Exit::Output {
                    return Err(CommandFailure { reports, exit: failure.exit });
                }
                if INTERRUPTED.load(Ordering::Relaxed) {
                    end = Exit::Interrupted;
                    break;
                }
            }
        }
    }
    match end {
        _ if reports.is_empty() => Ok(end),
        Exit::Interrupted => Err(CommandFailure { reports, exit: end }),
        _ => Err(CommandFailure { reports, exit: Exit::Output }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a series in which render i returns `ends[i]`. Returns the result of the series, and the
    /// number of renders that were started.
    fn series_outcome(ends: &[Result<Exit, Exit>]) -> (Result<Exit, (Exit, usize)>, usize) {
        let mut count = 0;
        let end = render_series(ends, |end| {
            count += 1;
            end.map_err(|exit| CommandFailure::new(exit, miette::miette!("failed")))
        });
        (end.map_err(|failure| (failure.exit, failure.reports.len())), count)
    }

    #[test]
    fn unwritable_pictures_do_not_end_a_series() {
        let (good, unwritable) = (Ok(Exit::Success), Err(Exit::Output));
        assert_eq!(series_outcome(&[good, good]), (Ok(Exit::Success), 2));
        assert_eq!(series_outcome(&[unwritable, good, unwritable, good]), (Err((Exit::Output, 2)), 4));
        assert_eq!(series_outcome(&[unwritable, Err(Exit::Usage), good]), (Err((Exit::Usage, 2)), 2));
        assert_eq!(series_outcome(&[good, Ok(Exit::Interrupted), good]), (Ok(Exit::Interrupted), 2));
        assert_eq!(series_outcome(&[unwritable, Ok(Exit::Interrupted), good]), (Err((Exit::Interrupted, 1)), 2));
    }
}
