//! Division of the passes of a render into shards, and lists of shard numbers.

use crate::cli::shard::Shard;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Division of a number of passes into shards: ranges of passes of almost equal size.
///
/// Shard k covers the same passes in all divisions with the same number of passes per shard. So
/// shards can be added to a render later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ShardDivision {
    /// Number of shards. The shards are numbered from 1.
    pub shards: u32,
    /// Number of passes of all shards together.
    pub passes: u32,
}

/// Tasks of one Slurm job array; each task renders one shard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ArrayTasks {
    /// Number of a task's shard minus the number of the task, equal for all tasks of the array.
    pub shard_offset: u32,
    /// Numbers of the tasks in sbatch's notation, such as `1-3,7`.
    pub tasks: String,
}

impl ShardDivision {
    /// Returns the indices (from 0) of the passes of shard `number`. Shards are numbered from 1.
    pub fn shard_passes(self, number: u32) -> Range<u32> {
        Shard { number, count: self.shards }.passes(self.passes)
    }

    /// True if both divisions have equal numbers of passes per shard. Shard k then covers the same
    /// passes in both divisions.
    pub fn has_same_shard_passes(self, other: Self) -> bool {
        u64::from(self.passes) * u64::from(other.shards) == u64::from(other.passes) * u64::from(self.shards)
    }

    /// Returns a division with `more` further shards of the same size. Returns `None` if this
    /// division has shards of unequal sizes, or if the new division would have more than `most`
    /// passes.
    pub fn with_more_shards(self, more: u32, most: u32) -> Option<Self> {
        let size = self.passes / self.shards;
        if size * self.shards != self.passes {
            return None;
        }
        let shards = self.shards.checked_add(more)?;
        let passes = shards.checked_mul(size).filter(|passes| *passes <= most)?;
        Some(Self { shards, passes })
    }
}

/// Returns job arrays that together run `shards`, a list of ascending shard numbers. The tasks of
/// each array have numbers from 1 to `most`.
pub(super) fn job_arrays(shards: &[u32], most: u32) -> Vec<ArrayTasks> {
    let array_of = |shard: u32| (shard - 1) / most;
    let arrays = shards.chunk_by(|a, b| array_of(*a) == array_of(*b));
    let array = |shards: &[u32]| {
        let offset = array_of(shards[0]) * most;
        let tasks: Vec<u32> = shards.iter().map(|shard| shard - offset).collect();
        ArrayTasks { shard_offset: offset, tasks: number_list(&tasks) }
    };
    arrays.map(array).collect()
}

/// Returns ascending numbers as a list of ranges, such as `1-3,7`.
pub(super) fn number_list(numbers: &[u32]) -> String {
    let ranges = numbers.chunk_by(|a, b| a + 1 == *b);
    let range = |range: &[u32]| match range {
        [one] => one.to_string(),
        [first, .., last] => format!("{first}-{last}"),
        [] => String::new(),
    };
    ranges.map(range).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn job_arrays_cover_all_shards() {
        let arrays = |shards: &[u32], most| {
            job_arrays(shards, most).into_iter().map(|array| (array.shard_offset, array.tasks)).collect::<Vec<_>>()
        };
        let own = |array: &[(u32, &str)]| array.iter().map(|(n, text)| (*n, (*text).to_owned())).collect::<Vec<_>>();
        assert_eq!(arrays(&[1, 2, 3, 7], 1000), own(&[(0, "1-3,7")]));
        assert_eq!(arrays(&[2, 4, 5, 8, 9], 4), own(&[(0, "2,4"), (4, "1,4"), (8, "1")]));
        let all: Vec<u32> = (1..=2500).collect();
        assert_eq!(arrays(&all, 1000), own(&[(0, "1-1000"), (1000, "1-1000"), (2000, "1-500")]));
        assert_eq!(arrays(&[], 1000), []);
    }

    /// Shards 1 to 6 have the same passes before and after three shards are added. The added shards
    /// have the passes that follow.
    #[test]
    fn added_shards_leave_earlier_shards_unchanged() {
        let first = ShardDivision { shards: 6, passes: 24 };
        let grown = first.with_more_shards(3, 100).unwrap();
        assert_eq!(grown, ShardDivision { shards: 9, passes: 36 });
        assert!(
            first.has_same_shard_passes(grown) && !first.has_same_shard_passes(ShardDivision { shards: 6, passes: 25 })
        );
        for shard in 1..=6 {
            assert_eq!(first.shard_passes(shard), grown.shard_passes(shard));
        }
        assert_eq!((grown.shard_passes(7), grown.shard_passes(9)), (24..28, 32..36));
        assert_eq!(first.with_more_shards(3, 35), None);
        assert_eq!(first.with_more_shards(u32::MAX, u32::MAX), None);
        assert_eq!(ShardDivision { shards: 3, passes: 7 }.with_more_shards(1, 100), None);
    }
}
