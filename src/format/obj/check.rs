//! The lines of an OBJ file that make up its faces, proved sound one by one.

use super::super::mesh::ReadMonitor;
use super::super::problem::{Problem, excerpt};
use rayon::prelude::*;
use std::borrow::Cow;
use std::fmt::Write;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Bytes of a chunk of lines, at least.
const CHUNK: usize = 1 << 22;

/// What is wrong with a line.
pub(super) struct LineError {
    /// From 1.
    pub line: usize,
    pub wrong: Problem,
}

/// The corner of a face: which of position, texture coordinate and normal it names.
type Named = [bool; 3];

/// What the three numbers of a corner point at.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// What is left of a file.
#[derive(Default)]
pub(super) struct Sound {
    /// Lines `v`, `vt`, `vn` and `f` in the order of the file, cut to what counts: finite numbers, and indices of what stands
    /// before. Within a group (parted by `g`), all corners name the same lists, and all faces have one material.
    pub texts: Vec<String>,
    /// The material of each group, empty where it has none.
    pub groups: Vec<String>,
    /// Files of materials, as written.
    pub libraries: Vec<String>,
    /// Numbers of all lines `v`, `vt` and `vn`.
    pub numbers: usize,
    /// Corners of all faces.
    pub corners: usize,
    /// Vertices of the file.
    pub vertices: usize,
    /// Vertices that no face names.
    pub isolated: usize,
}

/// The part of the text that counts, or the first line that is wrong.
pub(super) fn sound_lines(text: &str, monitor: &dyn ReadMonitor) -> Result<Sound, LineError> {
    let chunks = chunks(text);
    let tallies: Vec<Tally> = chunks.par_iter().map(|chunk| Tally::of(&text[chunk.clone()])).collect();
    let mut before = Vec::with_capacity(chunks.len());
    let mut total = Tally::default();
    for tally in &tallies {
        before.push(total);
        total.add(tally);
    }
    let used: Vec<AtomicBool> = (0..total.counts[0]).map(|_| AtomicBool::new(false)).collect();
    let checked: Vec<_> = chunks
        .par_iter()
        .zip(&before)
        .map(|(range, before)| {
            let checked = Chunk::check(&text[range.clone()], before, &used);
            monitor.advance(range.len() as u64 / 2);
            checked
        })
        .collect();
    let [v, vt, vn] = total.counts;
    let mut sound = Sound { vertices: v, numbers: 3 * v + 2 * vt + 3 * vn, ..Sound::default() };
    let mut material = String::new();
    for chunk in checked {
        let mut chunk: Chunk<'_> = chunk?;
        let name = |number: &usize| number.checked_sub(1).map_or(&material, |i| &chunk.names[i]).clone();
        sound.groups.extend(chunk.groups.iter().map(name));
        material = chunk.names.pop().unwrap_or(material);
        sound.corners += chunk.corners;
        sound.libraries.append(&mut chunk.libraries);
        sound.texts.push(chunk.sound);
    }
    sound.isolated = used.iter().filter(|used| !used.load(Relaxed)).count();
    Ok(sound)
}

/// Parts of the text that begin and end with lines; a line that a backslash continues stays whole.
fn chunks(text: &str) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut start = 0;
    while start < text.len() {
        let mut end = text.len().min(start + CHUNK);
        loop {
            end = memchr::memchr(b'\n', &text.as_bytes()[end..]).map_or(text.len(), |i| end + i + 1);
            if end == text.len() || !text[start..end].trim_end().ends_with('\\') {
                break;
            }
        }
        chunks.push(start..end);
        start = end;
    }
    chunks
}

/// How many lines and entries of the lists there are.
#[derive(Clone, Copy, Default)]
struct Tally {
    lines: usize,
    counts: [usize; 3],
}

impl Tally {
    fn of(text: &str) -> Self {
        let mut tally = Self::default();
        for_lines(text, |_, line| {
            match line.split_ascii_whitespace().next() {
                Some("v") => tally.counts[0] += 1,
                Some("vt") => tally.counts[1] += 1,
                Some("vn") => tally.counts[2] += 1,
                _ => {}
            }
            Ok::<(), ()>(())
        })
        .unwrap_or_default();
        tally.lines = memchr::memchr_iter(b'\n', text.as_bytes()).count();
        tally
    }

    fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        for (count, more) in self.counts.iter_mut().zip(other.counts) {
            *count += more;
        }
    }
}

/// Calls `visit` with the number from 0 and the text of each line that may count; a backslash at its end continues a line.
fn for_lines<E>(text: &str, mut visit: impl FnMut(usize, &str) -> Result<(), E>) -> Result<(), E> {
    let mut lines = text.lines().enumerate();
    while let Some((i, first)) = lines.next() {
        if !first.trim_ascii_start().starts_with(['v', 'f', 'm', 'u']) {
            continue;
        }
        let mut line = Cow::from(first);
        while line.ends_with('\\') || line.trim_end().ends_with('\\') {
            let line = line.to_mut();
            line.truncate(line.trim_end().len() - 1);
            line.push(' ');
            line.push_str(lines.next().map_or("", |(_, next)| next));
        }
        visit(i, &line)?;
    }
    Ok(())
}

/// A part of the text as it is checked.
struct Chunk<'u> {
    sound: String,
    /// Vertices, texture coordinates and normals so far, of the whole file.
    counts: [usize; 3],
    /// What the corners of the last face name, and the number of their material.
    group: Option<(Named, usize)>,
    /// Names of materials; number 0 is what was in force before the chunk.
    names: Vec<String>,
    /// Number of the material of each group.
    groups: Vec<usize>,
    libraries: Vec<String>,
    /// Corners of its faces.
    corners: usize,
    used: &'u [AtomicBool],
}

impl<'u> Chunk<'u> {
    fn check(text: &str, before: &Tally, used: &'u [AtomicBool]) -> Result<Self, LineError> {
        let mut chunk = Self {
            sound: String::with_capacity(text.len()),
            counts: before.counts,
            group: None,
            names: Vec::new(),
            groups: Vec::new(),
            libraries: Vec::new(),
            corners: 0,
            used,
        };
        for_lines(text, |i, line| chunk.line(line).map_err(|wrong| LineError { line: before.lines + i + 1, wrong }))?;
        Ok(chunk)
    }

    fn line(&mut self, line: &str) -> Result<(), Problem> {
        let line = line.trim_ascii_start();
        let end = line.find(|c: char| c.is_ascii_whitespace()).unwrap_or(line.len());
        let (keyword, rest) = line.split_at(end);
        // A comment may follow what counts; names may hold what looks like one.
        let words = || rest.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match keyword {
            "v" => self.numbers(0, "v", 3, 3, words()),
            "vt" => self.numbers(1, "vt", 1, 2, words()),
            "vn" => self.numbers(2, "vn", 3, 3, words()),
            "f" => self.face(words()),
            "usemtl" => {
                self.names.push(rest.trim().to_owned());
                Ok(())
            }
            "mtllib" => {
                self.libraries.push(rest.trim().to_owned());
                Ok(())
            }
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
    ) -> Result<(), Problem> {
        self.sound.push_str(keyword);
        for k in 0..most {
            let word = match words.next() {
                Some(word) => word,
                None if k < fewest => {
                    return Err((format!("`{keyword}` holds {k} numbers"), "give it as many as the format asks for"));
                }
                None => "0",
            };
            if !is_finite(word) {
                return Err((
                    format!("`{}` is not a finite number", excerpt(word)),
                    "repair it or export the mesh anew",
                ));
            }
            self.sound.push(' ');
            self.sound.push_str(word);
        }
        self.sound.push('\n');
        self.counts[list] += 1;
        Ok(())
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), Problem> {
        let mut corners = 0;
        for word in words {
            let indices = self.corner(word)?;
            let named = indices.map(|index| index != 0);
            let group = Some((named, self.names.len()));
            if corners == 0 && self.group != group {
                self.group = group;
                self.groups.push(self.names.len());
                self.sound.push_str("g\n");
            }
            if self.group != group {
                let message = "only some corners of the face name a normal or texture coordinate".to_owned();
                return Err((message, "write all corners of a face alike"));
            }
            self.used[indices[0] - 1].store(true, Relaxed);
            self.sound.push_str(if corners == 0 { "f " } else { " " });
            if word.contains('-') {
                let index_or_empty = |index: usize| if index == 0 { String::new() } else { index.to_string() };
                // Writing to a string cannot fail.
                let _ =
                    write!(self.sound, "{}/{}/{}", indices[0], index_or_empty(indices[1]), index_or_empty(indices[2]));
            } else {
                self.sound.push_str(word);
            }
            corners += 1;
        }
        if corners < 3 {
            return Err((format!("a face with {corners} corners"), "a face needs at least 3"));
        }
        self.corners += corners;
        self.sound.push('\n');
        Ok(())
    }

    /// The lists' numbers from 1 that a corner such as `3/1/2`, `3//2` or `-1` names; 0 for none.
    fn corner(&self, word: &str) -> Result<[usize; 3], Problem> {
        let mut indices = [0; 3];
        for (k, part) in word.split('/').enumerate() {
            if k > 2 || (part.is_empty() && k == 0) {
                let message = format!("`{}` is not a corner of a face", excerpt(word));
                return Err((message, "write v, v/vt, v//vn or v/vt/vn"));
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
                Some(i) if (1..=known).contains(&i) => indices[k] = i,
                _ => {
                    let message = format!("`{}` names no {} ({known} stand before it)", excerpt(word), LISTS[k]);
                    return Err((message, "indices count from 1, or from -1 backwards"));
                }
            }
        }
        Ok(indices)
    }
}

/// Whether a word is a number that is finite in double precision.
fn is_finite(word: &str) -> bool {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word).as_bytes();
    let (mut numerals, mut points) = (0, 0);
    for byte in digits {
        match byte {
            b'0'..=b'9' => numerals += 1,
            b'.' => points += 1,
            _ => return word.parse::<f64>().is_ok_and(f64::is_finite),
        }
    }
    // Fewer than 300 digits without an exponent stay below 1e300.
    match digits.len() {
        0..300 => numerals > 0 && points < 2,
        _ => word.parse::<f64>().is_ok_and(f64::is_finite),
    }
}
