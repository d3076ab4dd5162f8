//! "Did you mean …?"

/// Longer words are not typing errors of a keyword.
const LONGEST: usize = 40;

/// The candidate that is nearest to `word`, if it differs in at most a third of its letters; case does not count.
pub(in crate::format) fn nearest<'c>(word: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    let word: Vec<char> = word.chars().take(LONGEST + 1).flat_map(char::to_lowercase).collect();
    if word.len() > LONGEST {
        return None;
    }
    candidates
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| {
            let letters: Vec<char> = candidate.chars().flat_map(char::to_lowercase).collect();
            (distance(&word, &letters), letters.len(), candidate)
        })
        .filter(|&(distance, length, _)| distance <= length.max(word.len()) / 3)
        .min_by_key(|&(distance, ..)| distance)
        .map(|(.., candidate)| candidate)
}

/// Fewest letters to add, drop, change or swap with a neighbour (optimal string alignment).
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_are_recognised() {
        let words = || ["Sphere", "Plane", "radius", "lookAt", "color"].into_iter();
        for (word, keyword) in
            [("Spere", "Sphere"), ("Shpere", "Sphere"), ("RADIUS", "radius"), ("colour", "color"), ("lookat", "lookAt")]
        {
            assert_eq!(nearest(word, words()), Some(keyword));
        }
        assert_eq!(nearest("Torus", words()), None);
        assert_eq!(nearest("", words()), None);
        assert_eq!(nearest(&"Sphere".repeat(1000), words()), None);
    }
}
