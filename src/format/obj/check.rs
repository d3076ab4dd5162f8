//! The lines of an OBJ file that make up its faces, proved sound one by one.

use std::borrow::Cow;
use std::fmt::Write;

/// What is wrong with a line.
pub(super) struct LineError {
    pub line: usize,
    pub message: String,
    pub remedy: &'static str,
}

/// The corner of a face: which of position, texture coordinate and normal it names.
type Named = [bool; 3];

/// What the three numbers of a corner point at.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// The `v`, `vt`, `vn` and `f` lines of `text`, cut to what counts: finite numbers, and indices of what stands before.
///
/// Within a group of the result (parted by `g`), all corners name the same lists.
pub(super) fn sound_lines(text: &str) -> Result<String, LineError> {
    let mut sound = String::with_capacity(text.len());
    let mut counts = [0_usize; 3];
    let mut group: Option<Named> = None;
    let mut lines = text.lines().enumerate();
    while let Some((i, first)) = lines.next() {
        if !matches!(first.split_ascii_whitespace().next(), Some("v" | "vt" | "vn" | "f")) {
            continue;
        }
        let mut line = Cow::from(first);
        // A backslash at its end continues a line.
        while line.trim_end().ends_with('\\') {
            let line = line.to_mut();
            line.truncate(line.trim_end().len() - 1);
            line.push(' ');
            line.push_str(lines.next().map_or("", |(_, next)| next));
        }
        let checked = Line { sound: &mut sound, counts: &mut counts, group: &mut group }.check(&line);
        checked.map_err(|(message, remedy)| LineError { line: i + 1, message, remedy })?;
    }
    Ok(sound)
}

struct Line<'s> {
    sound: &'s mut String,
    /// Vertices, texture coordinates and normals so far.
    counts: &'s mut [usize; 3],
    /// What the corners of the last face name.
    group: &'s mut Option<Named>,
}

type Wrong = (String, &'static str);

impl Line<'_> {
    fn check(&mut self, line: &str) -> Result<(), Wrong> {
        // A comment may follow what counts.
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.numbers(0, "v", 3, 3, words),
            Some("vt") => self.numbers(1, "vt", 1, 2, words),
            Some("vn") => self.numbers(2, "vn", 3, 3, words),
            Some("f") => self.face(words),
            _ => Ok(()),
        }
    }

    /// Passes on `most` numbers, of which `fewest` must be there and others are 0; what follows them is dropped.
    fn numbers<'w>(
        &mut self,
        list: usize,
        keyword: &str,
        fewest: usize,
        most: usize,
        mut words: impl Iterator<Item = &'w str>,
    ) -> Result<(), Wrong> {
        self.sound.push_str(keyword);
        for k in 0..most {
            let word = match words.next() {
                Some(word) => word,
                None if k < fewest => {
                    return Err((format!("`{keyword}` holds {k} numbers"), "give it as many as the format asks for"));
                }
                None => "0",
            };
            if !word.parse::<f64>().is_ok_and(f64::is_finite) {
                let word = word.escape_debug().take(40).collect::<String>();
                return Err((format!("`{word}` is not a finite number"), "repair it or export the mesh anew"));
            }
            self.sound.push(' ');
            self.sound.push_str(word);
        }
        self.sound.push('\n');
        self.counts[list] += 1;
        Ok(())
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), Wrong> {
        let mut corners: Vec<[Option<usize>; 3]> = Vec::new();
        for word in words {
            corners.push(self.corner(word)?);
        }
        if corners.len() < 3 {
            return Err((format!("a face with {} corners", corners.len()), "a face needs at least 3"));
        }
        let named = corners[0].map(|index| index.is_some());
        if corners.iter().any(|corner| corner.map(|index| index.is_some()) != named) {
            let message = "only some corners of the face name a normal or texture coordinate".to_owned();
            return Err((message, "write all corners of a face alike"));
        }
        if *self.group != Some(named) {
            *self.group = Some(named);
            self.sound.push_str("g\n");
        }
        self.sound.push('f');
        for [v, vt, vn] in corners {
            let shown = |index: Option<usize>| index.map(|i| i.to_string()).unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = write!(self.sound, " {}/{}/{}", shown(v), shown(vt), shown(vn));
        }
        self.sound.push('\n');
        Ok(())
    }

    /// The lists' numbers from 1 that a corner such as `3/1/2`, `3//2` or `-1` names.
    fn corner(&self, word: &str) -> Result<[Option<usize>; 3], Wrong> {
        let mut indices = [None; 3];
        let shown = || word.escape_debug().take(40).collect::<String>();
        for (k, part) in word.split('/').enumerate() {
            if k > 2 || (part.is_empty() && k == 0) {
                return Err((format!("`{}` is not a corner of a face", shown()), "write v, v/vt, v//vn or v/vt/vn"));
            }
            if part.is_empty() {
                continue;
            }
            let known = self.counts[k];
            let index = match part.parse::<i64>() {
                Ok(i) if i > 0 => usize::try_from(i).ok(),
                Ok(i) if i < 0 => usize::try_from(i.unsigned_abs()).ok().and_then(|i| (known + 1).checked_sub(i)),
                _ => None,
            };
            match index {
                Some(i) if (1..=known).contains(&i) => indices[k] = Some(i),
                _ => {
                    let message = format!("`{}` names no {} ({known} stand before it)", shown(), LISTS[k]);
                    return Err((message, "indices count from 1, or from -1 backwards"));
                }
            }
        }
        Ok(indices)
    }
}
