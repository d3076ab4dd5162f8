//! Shards: parts of the passes of a render, which several processes render separately.

use std::ops::Range;
use std::str::FromStr;

/// Part of the passes of a render that one process makes, such as `3/16`: the third of 16 parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of this part, counted from 1.
    pub number: u32,
    /// Number of parts into which the passes are divided.
    pub count: u32,
}

impl Shard {
    /// Returns the indices (from 0) of the passes that this part makes in a render of `passes`
    /// passes.
    ///
    /// The sizes of parts differ by at most one pass.
    #[must_use]
    pub fn passes(self, passes: u32) -> Range<u32> {
        let end_of = |number: u32| (u64::from(passes) * u64::from(number) / u64::from(self.count)) as u32;
        end_of(self.number - 1)..end_of(self.number)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((number, count)) if 1 <= number && number <= count => Ok(Self { number, count }),
            Some((_, count)) => Err(format!("`{text}` is no part: write 1/{count} to {count}/{count}")),
            None => Err(format!("`{text}` is no part: write 3/16 for the third of 16 parts")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_the_passes() {
        for (passes, count) in [(320, 16), (7, 3), (2, 5), (u32::MAX, 3)] {
            let shards = (1..=count).map(|number| Shard { number, count }.passes(passes));
            let mut next = 0;
            for shard in shards {
                assert_eq!(shard.start, next);
                assert!(shard.len() as u32 <= passes.div_ceil(count));
                next = shard.end;
            }
            assert_eq!(next, passes);
        }
        assert_eq!("3/16".parse(), Ok(Shard { number: 3, count: 16 }));
        for wrong in ["0/4", "5/4", "3", "a/b", "1/0", "-1/2", "1/99999999999"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
