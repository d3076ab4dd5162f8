//! Limit of the time that a render spends on showing its picture: on the live page and in tev.

use std::time::{Duration, Instant};

/// Smallest ratio of the pause after a publication to the duration of the publication. At the ratio
/// 100, publications take at most 1 % of the time of a render.
const MIN_INTERVAL_FACTOR: u32 = 100;

/// Shortest pause after a publication, however short the publication was.
const MIN_INTERVAL: Duration = Duration::from_millis(100);

/// Throttle that limits how often a running render publishes its picture.
#[derive(Debug, Default)]
pub(super) struct PublicationThrottle {
    /// Earliest time of the next publication; `None` before the first one.
    next: Option<Instant>,
}

impl PublicationThrottle {
    /// True if a publication is due at the time `now`.
    pub fn is_due(&self, now: Instant) -> bool {
        self.next.is_none_or(|next| now >= next)
    }

    /// Records a publication that lasted from `start` to `end`.
    pub fn record(&mut self, start: Instant, end: Instant) {
        self.next = Some(end + MIN_INTERVAL.max((end - start) * MIN_INTERVAL_FACTOR));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn publications_take_at_most_one_percent() {
        let start = Instant::now();
        let after = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut throttle = PublicationThrottle::default();
        assert!(throttle.is_due(start));
        throttle.record(start, after(10));
        assert!(!throttle.is_due(after(1009)) && throttle.is_due(after(1010)));
        throttle.record(start, start);
        assert!(!throttle.is_due(after(99)) && throttle.is_due(after(100)));
    }
}
