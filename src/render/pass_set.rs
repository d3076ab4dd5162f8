//! Sets of pass numbers, stored as ranges.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;

/// Set of pass numbers, which count from 0.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PassSet {
    /// Disjoint ranges of pass numbers, in ascending order and with gaps between them.
    ranges: Vec<Range<u32>>,
}

impl PassSet {
    /// Returns the number of passes in the set.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.ranges.iter().map(|range| u64::from(range.end - range.start)).sum()
    }

    /// True if the set is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Adds the pass numbers of `range`; numbers that are in the set already have no effect.
    pub fn insert(&mut self, range: Range<u32>) {
        if range.is_empty() {
            return;
        }
        // Join the ranges that touch the new one.
        let first = self.ranges.partition_point(|other| other.end < range.start);
        let last = self.ranges.partition_point(|other| other.start <= range.end);
        let joined = self.ranges[first..last].iter();
        let joined = joined.fold(range, |all, other| all.start.min(other.start)..all.end.max(other.end));
        self.ranges.splice(first..last, [joined]);
    }

    /// Adds the pass numbers of `other`; numbers that are in the set already have no effect.
    pub fn insert_all(&mut self, other: &Self) {
        other.ranges.iter().for_each(|range| self.insert(range.clone()));
    }

    /// Returns the lowest pass number of `range` that is not in the set; `None` if all are in the
    /// set.
    #[must_use]
    pub fn first_missing(&self, range: Range<u32>) -> Option<u32> {
        let next = self.ranges.iter().find(|own| own.contains(&range.start)).map_or(range.start, |own| own.end);
        range.contains(&next).then_some(next)
    }

    /// Returns the passes with numbers below `end` that are not in the set.
    #[must_use]
    pub fn missing_below(&self, end: u32) -> Self {
        let mut missing = Self::default();
        let mut next = 0;
        for range in &self.ranges {
            missing.insert(next..range.start.min(end));
            next = range.end;
        }
        missing.insert(next..end);
        missing
    }

    /// Returns the passes that are in both sets.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        let mut common = Self::default();
        for own in &self.ranges {
            for range in &other.ranges {
                common.insert(own.start.max(range.start)..own.end.min(range.end));
            }
        }
        common
    }

    /// Returns one more than the largest pass number; 0 if there are no passes.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.ranges.last().map_or(0, |range| range.end)
    }

    /// True if the ranges are in ascending order with gaps between them, as all other methods
    /// assume.
    ///
    /// False for some sets that were read from damaged files.
    pub(super) fn is_consistent(&self) -> bool {
        self.ranges.iter().all(|range| range.start < range.end)
            && self.ranges.windows(2).all(|pair| pair[0].end < pair[1].start)
    }
}

/// Formats the pass numbers as ranges that count from 1, such as `1–20, 31`.
impl fmt::Display for PassSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Range { start, end }) in self.ranges.iter().enumerate() {
            f.write_str(if i > 0 { ", " } else { "" })?;
            match end - start {
                1 => write!(f, "{end}")?,
                _ => write!(f, "{}–{end}", u64::from(*start) + 1)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(ranges: &[(u32, u32)]) -> PassSet {
        let mut set = PassSet::default();
        ranges.iter().for_each(|(start, end)| set.insert(*start..*end));
        assert!(set.is_consistent());
        set
    }

    #[test]
    fn ranges_join_where_they_touch() {
        assert_eq!(set(&[(5, 7), (0, 2), (2, 3), (9, 10)]).to_string(), "1–3, 6–7, 10");
        assert_eq!(set(&[(0, 2), (4, 6), (8, 9), (1, 8)]), set(&[(0, 9)]));
        assert_eq!(set(&[(3, 3)]), PassSet::default());
        assert_eq!((set(&[(1, 3), (7, 9)]).len(), set(&[(1, 3), (7, 9)]).end()), (4, 9));
    }

    #[test]
    fn missing_passes_complete_the_set() {
        let some = set(&[(1, 3), (7, 9)]);
        assert_eq!(some.missing_below(12), set(&[(0, 1), (3, 7), (9, 12)]));
        assert_eq!(some.missing_below(8), set(&[(0, 1), (3, 7)]));
        let firsts = [0..9, 1..9, 2..3, 8..9, 20..30].map(|range| some.first_missing(range));
        assert_eq!(firsts, [Some(0), Some(3), None, None, Some(20)]);
        assert_eq!(some.intersection(&set(&[(2, 8)])), set(&[(2, 3), (7, 8)]));
        assert!(some.intersection(&set(&[(3, 7)])).is_empty());
        let mut all = some.missing_below(12);
        all.insert_all(&some);
        assert_eq!(all, set(&[(0, 12)]));
    }
}
