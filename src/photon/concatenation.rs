//! Concatenation of many lists to one, with a parallel copy of the items.

use rayon::iter::plumbing::{Consumer, Producer, ProducerCallback, UnindexedConsumer, bridge};
use rayon::prelude::*;
use std::iter::FusedIterator;
use std::ops::Range;
use std::slice;

/// Smallest number of items that one Rayon task copies.
const MIN_ITEMS_PER_TASK: usize = 4096;

/// Concatenates `parts` to one list, in order. The items are copied in parallel.
pub(super) fn concatenate<T: Copy + Send + Sync>(parts: &[&[T]]) -> Vec<T> {
    let starts: Vec<usize> = parts
        .iter()
        .scan(0, |end, part| {
            let start = *end;
            *end += part.len();
            Some(start)
        })
        .collect();
    let len = starts.last().map_or(0, |start| start + parts[parts.len() - 1].len());
    Concatenation { parts, starts: &starts, range: 0..len }.with_min_len(MIN_ITEMS_PER_TASK).copied().collect()
}

/// Parallel iterator over consecutive items of several lists, taken as one concatenated list.
///
/// Rayon's `flatten` does not know the number of its items. This iterator does, so its items are
/// collected without another copy.
struct Concatenation<'a, T> {
    parts: &'a [&'a [T]],
    /// Start of each part: the index that the part's first item has in the concatenation.
    starts: &'a [usize],
    /// Range of indices into the concatenation over which this iterator runs.
    range: Range<usize>,
}

/// Iterator over the items of a [`Concatenation`].
struct ConcatenationIter<'a, T> {
    /// Remaining items of the first part.
    front: slice::Iter<'a, T>,
    /// Whole parts between `front` and `back`.
    middle: slice::Iter<'a, &'a [T]>,
    /// Remaining items of the last part; empty if all remaining items lie in one part.
    back: slice::Iter<'a, T>,
}

impl<'a, T> Concatenation<'a, T> {
    /// Returns the index of the part (one of the concatenated lists) that holds the item with index
    /// `item` in the concatenation.
    fn part_of(&self, item: usize) -> usize {
        self.starts.partition_point(|start| *start <= item) - 1
    }
}

impl<'a, T: Sync> ParallelIterator for Concatenation<'a, T> {
    type Item = &'a T;

    fn drive_unindexed<C: UnindexedConsumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge(self, consumer)
    }

    fn opt_len(&self) -> Option<usize> {
        Some(self.range.len())
    }
}

impl<T: Sync> IndexedParallelIterator for Concatenation<'_, T> {
    fn len(&self) -> usize {
        self.range.len()
    }

    fn drive<C: Consumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge(self, consumer)
    }

    fn with_producer<B: ProducerCallback<Self::Item>>(self, callback: B) -> B::Output {
        callback.callback(self)
    }
}

impl<'a, T: Sync> Producer for Concatenation<'a, T> {
    type Item = &'a T;
    type IntoIter = ConcatenationIter<'a, T>;

    fn into_iter(self) -> ConcatenationIter<'a, T> {
        let Range { start, end } = self.range;
        if start == end {
            return ConcatenationIter { front: [].iter(), middle: [].iter(), back: [].iter() };
        }
        let (first, last) = (self.part_of(start), self.part_of(end - 1));
        let (from, to) = (start - self.starts[first], end - self.starts[last]);
        if first == last {
            let front = self.parts[first][from..to].iter();
            return ConcatenationIter { front, middle: [].iter(), back: [].iter() };
        }
        ConcatenationIter {
            front: self.parts[first][from..].iter(),
            middle: self.parts[first + 1..last].iter(),
            back: self.parts[last][..to].iter(),
        }
    }

    fn split_at(self, index: usize) -> (Self, Self) {
        let Self { parts, starts, range } = self;
        let middle = range.start + index;
        (Self { parts, starts, range: range.start..middle }, Self { parts, starts, range: middle..range.end })
    }
}

impl<'a, T> Iterator for ConcatenationIter<'a, T> {
    type Item = &'a T;

    #[inline]
    fn next(&mut self) -> Option<&'a T> {
        loop {
            if let Some(item) = self.front.next() {
                return Some(item);
            }
            match self.middle.next() {
                Some(part) => self.front = part.iter(),
                None => return self.back.next(),
            }
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let middle: usize = self.middle.as_slice().iter().map(|part| part.len()).sum();
        let len = self.front.len() + middle + self.back.len();
        (len, Some(len))
    }
}

impl<T> DoubleEndedIterator for ConcatenationIter<'_, T> {
    fn next_back(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(item) = self.back.next_back() {
                return Some(item);
            }
            match self.middle.next_back() {
                Some(part) => self.back = part.iter(),
                None => return self.front.next_back(),
            }
        }
    }
}

impl<T> ExactSizeIterator for ConcatenationIter<'_, T> {}

impl<T> FusedIterator for ConcatenationIter<'_, T> {}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that lists of any lengths, even empty ones, are concatenated to the same list as by a
    /// serial copy.
    #[test]
    fn parts_are_joined_in_order() {
        let lists = |lengths: &[usize]| {
            let mut next = 0..;
            lengths.iter().map(|len| next.by_ref().take(*len).collect::<Vec<u32>>()).collect::<Vec<_>>()
        };
        let many: Vec<usize> = (0..300).map(|i| i * 7919 % 600).collect();
        for lengths in [&[][..], &[0], &[3], &[0, 0, 5, 0, 1, 0], &[9000, 0, 1, 20_000], &many] {
            let lists = lists(lengths);
            let parts: Vec<&[u32]> = lists.iter().map(Vec::as_slice).collect();
            let joined = lists.concat();
            assert_eq!(concatenate(&parts), joined, "{lengths:?}");
            let starts: Vec<usize> = (0..parts.len()).map(|i| lengths[..i].iter().sum()).collect();
            let all = Concatenation { parts: &parts, starts: &starts, range: 0..joined.len() };
            let items = Producer::into_iter(all);
            assert_eq!(items.len(), joined.len());
            assert!(items.rev().eq(joined.iter().rev()), "{lengths:?}");
        }
    }
}
