//! Numbers of passes after which the error of a picture is estimated.

/// Ratio of the numbers of passes at two successive error estimates. More frequent estimates would
/// slow renders, because one estimate takes a fraction of the time of a pass.
const INTERVAL_FACTOR: f64 = 1.05;

/// Schedule of error estimates: after each of the first passes, and then each time that the number
/// of passes has grown by a twentieth.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimateSchedule {
    /// Number of passes at which the next error estimate is due.
    next: f64,
}

impl EstimateSchedule {
    /// Returns true if an error estimate is due after `passes` passes. If so, schedules the next
    /// estimate. `passes` must ascend from call to call.
    pub fn advance_if_due(&mut self, passes: u32) -> bool {
        let due = f64::from(passes) >= self.next;
        if due {
            self.next = INTERVAL_FACTOR * f64::from(passes);
        }
        due
    }

    /// Returns all numbers of passes after which error estimates are due, in ascending order.
    pub fn due_passes() -> impl Iterator<Item = u32> {
        let next = |passes: &u32| Some(((INTERVAL_FACTOR * f64::from(*passes)).ceil() as u32).max(passes + 1));
        std::iter::successors(Some(1), next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_passes_are_those_of_the_schedule() {
        let mut schedule = EstimateSchedule::default();
        let due: Vec<u32> = (1..=2000).filter(|passes| schedule.advance_if_due(*passes)).collect();
        assert_eq!(due, EstimateSchedule::due_passes().take_while(|passes| *passes <= 2000).collect::<Vec<_>>());
        assert_eq!(due[..5], [1, 2, 3, 4, 5]);
        assert!(due.len() < 120, "{}", due.len());
    }
}
