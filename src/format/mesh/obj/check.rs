//! Checks the lines of an OBJ file that define its faces.

use crate::format::line_error::{MessageAndRemedy, escaped_excerpt};
use crate::format::mesh::MeshReadMonitor;
use rayon::prelude::*;
use std::borrow::Cow;
use std::fmt::Write;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Least number of bytes in a chunk of lines.
const CHUNK: usize = 1 << 22;

/// Invalid line.
pub(super) struct InvalidLine {
    /// Line number, from 1.
    pub line: usize,
    pub wrong: MessageAndRemedy,
}

/// True for the position, texture coordinate and normal that a corner of a face names.
type PresentIndices = [bool; 3];

/// Names of the lists that the three indices of a corner refer to.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Checked content of a file.
#[derive(Default)]
pub(super) struct CheckedObj {
    /// Lines `v`, `vt`, `vn` and `f` in the order of the file, with finite numbers and valid
    /// indices.
    ///
    /// Groups are divided by `g`. Within a group, all corners name the same lists, and all faces
    /// have one material.
    pub texts: Vec<String>,
    /// Material of each group; empty if it has none.
    pub groups: Vec<String>,
    /// Material files, as written.
    pub libraries: Vec<String>,
    /// Number of values on all lines `v`, `vt` and `vn`.
    pub numbers: usize,
    /// Number of corners of all faces.
    pub corners: usize,
    /// Number of vertices in the file.
    pub vertices: usize,
    /// Number of vertices that no face names.
    pub isolated: usize,
}

/// Extracts the valid lines; fails at the first invalid line.
pub(super) fn check_obj_lines(text: &str, monitor: &dyn MeshReadMonitor) -> Result<CheckedObj, InvalidLine> {
    let chunks = line_chunks(text);
    let tallies: Vec<LineCounts> = chunks.par_iter().map(|chunk| LineCounts::count(&text[chunk.clone()])).collect();
    let mut before = Vec::with_capacity(chunks.len());
    let mut total = LineCounts::default();
    for tally in &tallies {
        before.push(total);
        total.add(tally);
    }
    let used: Vec<AtomicBool> = (0..total.counts[0]).map(|_| AtomicBool::new(false)).collect();
    let checked: Vec<_> = chunks
        .par_iter()
        .zip(&before)
        .map(|(range, before)| {
            let checked = ChunkChecker::check_chunk(&text[range.clone()], before, &used);
            monitor.advance(range.len() as u64 / 2);
            checked
        })
        .collect();
    let [v, vt, vn] = total.counts;
    let mut sound = CheckedObj { vertices: v, numbers: 3 * v + 2 * vt + 3 * vn, ..CheckedObj::default() };
    let mut material = String::new();
    for chunk in checked {
        let mut chunk: ChunkChecker<'_> = chunk?;
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

/// Byte ranges that begin and end at line boundaries; a line continued by a backslash is not
/// divided.
fn line_chunks(text: &str) -> Vec<Range<usize>> {
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

/// Number of lines, and of entries in each list.
#[derive(Clone, Copy, Default)]
struct LineCounts {
    lines: usize,
    counts: [usize; 3],
}

impl LineCounts {
    fn count(text: &str) -> Self {
        let mut tally = Self::default();
        for_each_statement(text, |_, line| {
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

/// Calls `visit` with the index, from 0, and the text of each relevant line.
///
/// A backslash at the end continues a line.
fn for_each_statement<E>(text: &str, mut visit: impl FnMut(usize, &str) -> Result<(), E>) -> Result<(), E> {
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

/// Part of the text while it is checked.
struct ChunkChecker<'u> {
    sound: String,
    /// Numbers of vertices, texture coordinates and normals so far, in the whole file.
    counts: [usize; 3],
    /// Lists that the corners of the last face name, and the index of its material.
    group: Option<(PresentIndices, usize)>,
    /// Names of materials; index 0 is the material in force before the chunk.
    names: Vec<String>,
    /// Index of the material of each group.
    groups: Vec<usize>,
    libraries: Vec<String>,
    /// Number of corners of the chunk's faces.
    corners: usize,
    used: &'u [AtomicBool],
}

impl<'u> ChunkChecker<'u> {
    fn check_chunk(text: &str, before: &LineCounts, used: &'u [AtomicBool]) -> Result<Self, InvalidLine> {
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
        for_each_statement(text, |i, line| {
            chunk.check_line(line).map_err(|wrong| InvalidLine { line: before.lines + i + 1, wrong })
        })?;
        Ok(chunk)
    }

    fn check_line(&mut self, line: &str) -> Result<(), MessageAndRemedy> {
        let line = line.trim_ascii_start();
        let end = line.find(|c: char| c.is_ascii_whitespace()).unwrap_or(line.len());
        let (keyword, rest) = line.split_at(end);
        // A comment may follow the numbers; names may contain `#`.
        let words = || rest.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match keyword {
            "v" => self.copy_numbers(0, "v", 3, 3, words()),
            "vt" => self.copy_numbers(1, "vt", 1, 2, words()),
            "vn" => self.copy_numbers(2, "vn", 3, 3, words()),
            "f" => self.check_face(words()),
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

    /// Copies `most` numbers; at least `fewest` must be present, the others are 0, and the rest is
    /// dropped.
    fn copy_numbers<'w>(
        &mut self,
        list: usize,
        keyword: &str,
        fewest: usize,
        most: usize,
        mut words: impl Iterator<Item = &'w str>,
    ) -> Result<(), MessageAndRemedy> {
        self.sound.push_str(keyword);
        for k in 0..most {
            let word = match words.next() {
                Some(word) => word,
                None if k < fewest => {
                    return Err((format!("`{keyword}` holds {k} numbers"), "give it as many as the format asks for"));
                }
                None => "0",
            };
            if !is_finite_number(word) {
                return Err((
                    format!("`{}` is not a finite number", escaped_excerpt(word)),
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

    fn check_face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), MessageAndRemedy> {
        let mut corners = 0;
        for word in words {
            let indices = self.parse_corner(word)?;
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

    /// Indices from 1 of a corner such as `3/1/2`, `3//2` or `-1`; 0 for an omitted index.
    fn parse_corner(&self, word: &str) -> Result<[usize; 3], MessageAndRemedy> {
        let mut indices = [0; 3];
        for (k, part) in word.split('/').enumerate() {
            if k > 2 || (part.is_empty() && k == 0) {
                let message = format!("`{}` is not a corner of a face", escaped_excerpt(word));
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
                    let message =
                        format!("`{}` names no {} ({known} stand before it)", escaped_excerpt(word), LISTS[k]);
                    return Err((message, "indices count from 1, or from -1 backwards"));
                }
            }
        }
        Ok(indices)
    }
}

/// True if a word is a number that is finite in double precision.
fn is_finite_number(word: &str) -> bool {
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
