//! Checks the lines of an OBJ file, in parallel, and copies the valid lines for `tobj`.

use crate::format::line_error::{MessageAndRemedy, escaped_excerpt};
use crate::format::mesh::MeshReadMonitor;
use rayon::prelude::*;
use std::borrow::Cow;
use std::fmt::Write;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Smallest size of the chunks of lines that threads check \[bytes]. Only the last chunk may be
/// smaller.
const MIN_CHUNK_BYTES: usize = 1 << 22;

/// An invalid line of an OBJ file, with the defect and a remedy.
pub(super) struct InvalidObjLine {
    /// Line number, from 1.
    pub line: usize,
    pub defect: MessageAndRemedy,
}

/// Three flags of a face corner: whether it has the index of a position, of a texture coordinate,
/// and of a normal, in this order.
type PresentIndices = [bool; 3];

/// Names, for error messages, of the items that the three indices of a face corner refer to.
const V_VT_VN_NAMES: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// Content of an OBJ file whose lines have all been checked.
#[derive(Default)]
pub(super) struct CheckedObjFile {
    /// Valid lines `v`, `vt`, `vn` and `f` in the order of the file, one text per chunk.
    ///
    /// Lines `g`, which the check inserts, divide the faces into groups. All faces of a group have
    /// one material. Texture coordinates are given at all corners of a group or at none, and so are
    /// normals.
    pub chunk_texts: Vec<String>,
    /// Name of each group's material; empty for groups without material.
    pub group_material_names: Vec<String>,
    /// Arguments of the lines `mtllib`, as written: paths of MTL files.
    pub mtllib_arguments: Vec<String>,
    /// Number of coordinates on all lines `v`, `vt` and `vn`.
    pub coordinate_count: usize,
    /// Number of corners of all faces, before triangulation.
    pub corner_count: usize,
    /// Number of vertices in the file: lines `v`.
    pub vertex_count: usize,
    /// Number of vertices in the file (lines `v`) that no face uses.
    pub isolated_vertex_count: usize,
}

/// Checks all lines of an OBJ file and rewrites them for `tobj`; fails at the first invalid line.
pub(super) fn check_and_rewrite_obj(
    text: &str,
    monitor: &dyn MeshReadMonitor,
) -> Result<CheckedObjFile, InvalidObjLine> {
    let chunks = line_chunks(text);
    let chunk_counts: Vec<ObjLineCounts> =
        chunks.par_iter().map(|chunk| ObjLineCounts::count_lines(&text[chunk.clone()])).collect();
    let mut before = Vec::with_capacity(chunks.len());
    let mut total = ObjLineCounts::default();
    for counts in &chunk_counts {
        before.push(total);
        total.add(counts);
    }
    let used: Vec<AtomicBool> = (0..total.v_vt_vn_counts[0]).map(|_| AtomicBool::new(false)).collect();
    let checked: Vec<_> = chunks
        .par_iter()
        .zip(&before)
        .map(|(range, before)| {
            let checked = ObjChunkChecker::check_obj_chunk(&text[range.clone()], before, &used);
            monitor.on_bytes_parsed(range.len() as u64 / 2);
            checked
        })
        .collect();
    let [v, vt, vn] = total.v_vt_vn_counts;
    let mut result =
        CheckedObjFile { vertex_count: v, coordinate_count: 3 * v + 2 * vt + 3 * vn, ..CheckedObjFile::default() };
    let mut material = String::new();
    for chunk in checked {
        let mut chunk: ObjChunkChecker<'_> = chunk?;
        let name = |number: &usize| number.checked_sub(1).map_or(&material, |i| &chunk.usemtl_names[i]).clone();
        result.group_material_names.extend(chunk.group_material_indices.iter().map(name));
        material = chunk.usemtl_names.pop().unwrap_or(material);
        result.corner_count += chunk.corner_count;
        result.mtllib_arguments.append(&mut chunk.mtllib_arguments);
        result.chunk_texts.push(chunk.valid_lines);
    }
    result.isolated_vertex_count = used.iter().filter(|used| !used.load(Relaxed)).count();
    Ok(result)
}

/// Divides `text` into byte ranges of whole lines. Lines joined by a backslash stay in one range.
fn line_chunks(text: &str) -> Vec<Range<usize>> {
    let mut chunks = Vec::new();
    let mut start = 0;
    while start < text.len() {
        let mut end = text.len().min(start + MIN_CHUNK_BYTES);
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

/// Line counts of a chunk of an OBJ file.
#[derive(Clone, Copy, Default)]
struct ObjLineCounts {
    /// Number of all lines of the chunk.
    line_count: usize,
    /// Numbers of lines `v`, `vt` and `vn`, in this order.
    v_vt_vn_counts: [usize; 3],
}

impl ObjLineCounts {
    fn count_lines(text: &str) -> Self {
        let mut counts = Self::default();
        for_each_statement(text, |_, line| {
            match line.split_ascii_whitespace().next() {
                Some("v") => counts.v_vt_vn_counts[0] += 1,
                Some("vt") => counts.v_vt_vn_counts[1] += 1,
                Some("vn") => counts.v_vt_vn_counts[2] += 1,
                _ => {}
            }
            Ok::<(), ()>(())
        })
        .unwrap_or_default();
        counts.line_count = memchr::memchr_iter(b'\n', text.as_bytes()).count();
        counts
    }

    fn add(&mut self, other: &Self) {
        self.line_count += other.line_count;
        for (count, more) in self.v_vt_vn_counts.iter_mut().zip(other.v_vt_vn_counts) {
            *count += more;
        }
    }
}

/// Calls `visit` with the index, from 0, and the text of each line that may hold a statement.
///
/// A line that ends with a backslash is joined with the next line, unless the line is a comment.
/// Statements that do not begin with `v`, `f`, `m` or `u` are skipped, because Caustica needs no
/// others.
fn for_each_statement<E>(text: &str, mut visit: impl FnMut(usize, &str) -> Result<(), E>) -> Result<(), E> {
    let mut lines = text.lines().enumerate();
    while let Some((i, first)) = lines.next() {
        let statement = first.trim_ascii_start();
        let is_needed = statement.starts_with(['v', 'f', 'm', 'u']);
        if !is_needed && (statement.starts_with('#') || !statement.trim_end().ends_with('\\')) {
            continue;
        }
        let mut line = Cow::from(first);
        while line.ends_with('\\') || line.trim_end().ends_with('\\') {
            let line = line.to_mut();
            line.truncate(line.trim_end().len() - 1);
            line.push(' ');
            line.push_str(lines.next().map_or("", |(_, next)| next));
        }
        if is_needed {
            visit(i, &line)?;
        }
    }
    Ok(())
}

/// State of the check of one chunk of lines of an OBJ file, and the content found so far.
struct ObjChunkChecker<'u> {
    valid_lines: String,
    /// Numbers of lines `v`, `vt` and `vn` read so far, counted from the start of the file.
    v_vt_vn_counts_so_far: [usize; 3],
    /// Group of the last face: the indices that its face corners have, and its material index,
    /// which `group_material_indices` explains. `None` before the first face.
    current_group: Option<(PresentIndices, usize)>,
    /// Names on the `usemtl` lines of the chunk, in order.
    usemtl_names: Vec<String>,
    /// Material of each face group. Index i + 1 stands for name i of `usemtl_names`, and index 0
    /// for the last material of the previous chunk.
    group_material_indices: Vec<usize>,
    mtllib_arguments: Vec<String>,
    /// Number of corners of the chunk's faces.
    corner_count: usize,
    /// Flags of all vertex positions of the file: true once a face uses the position. The checkers
    /// of all chunks set flags in this one list.
    used_positions: &'u [AtomicBool],
}

impl<'u> ObjChunkChecker<'u> {
    fn check_obj_chunk(text: &str, before: &ObjLineCounts, used: &'u [AtomicBool]) -> Result<Self, InvalidObjLine> {
        let mut chunk = Self {
            valid_lines: String::with_capacity(text.len()),
            v_vt_vn_counts_so_far: before.v_vt_vn_counts,
            current_group: None,
            usemtl_names: Vec::new(),
            group_material_indices: Vec::new(),
            mtllib_arguments: Vec::new(),
            corner_count: 0,
            used_positions: used,
        };
        for_each_statement(text, |i, line| {
            chunk.append_valid_line(line).map_err(|defect| InvalidObjLine { line: before.line_count + i + 1, defect })
        })?;
        Ok(chunk)
    }

    fn append_valid_line(&mut self, line: &str) -> Result<(), MessageAndRemedy> {
        let line = line.trim_ascii_start();
        let end = line.find(|c: char| c.is_ascii_whitespace()).unwrap_or(line.len());
        let (keyword, rest) = line.split_at(end);
        // A comment may follow the numbers; names may contain `#`.
        let words = || rest.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match keyword {
            "v" => self.append_valid_numbers(0, "v", 3, 3, words()),
            "vt" => self.append_valid_numbers(1, "vt", 1, 2, words()),
            "vn" => self.append_valid_numbers(2, "vn", 3, 3, words()),
            "f" => self.append_valid_face(words()),
            "usemtl" => {
                self.usemtl_names.push(rest.trim().to_owned());
                Ok(())
            }
            "mtllib" => {
                self.mtllib_arguments.push(rest.trim().to_owned());
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Copies the numbers of a line `v`, `vt` or `vn` to the valid lines. The line must hold at
    /// least `fewest` numbers, and the copy has exactly `most`.
    ///
    /// Numbers that the line lacks become 0, and surplus numbers are dropped.
    fn append_valid_numbers<'w>(
        &mut self,
        list: usize,
        keyword: &str,
        fewest: usize,
        most: usize,
        mut words: impl Iterator<Item = &'w str>,
    ) -> Result<(), MessageAndRemedy> {
        self.valid_lines.push_str(keyword);
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
            self.valid_lines.push(' ');
            self.valid_lines.push_str(word);
        }
        self.valid_lines.push('\n');
        self.v_vt_vn_counts_so_far[list] += 1;
        Ok(())
    }

    fn append_valid_face<'w>(&mut self, words: impl Iterator<Item = &'w str>) -> Result<(), MessageAndRemedy> {
        let mut corners = 0;
        for word in words {
            let indices = self.parse_obj_corner(word)?;
            let named = indices.map(|index| index != 0);
            let group = Some((named, self.usemtl_names.len()));
            if corners == 0 && self.current_group != group {
                self.current_group = group;
                self.group_material_indices.push(self.usemtl_names.len());
                self.valid_lines.push_str("g\n");
            }
            if self.current_group != group {
                let message = "only some corners of the face name a normal or texture coordinate".to_owned();
                return Err((message, "write all corners of a face alike"));
            }
            self.used_positions[indices[0] - 1].store(true, Relaxed);
            self.valid_lines.push_str(if corners == 0 { "f " } else { " " });
            if word.contains('-') {
                let index_or_empty = |index: usize| if index == 0 { String::new() } else { index.to_string() };
                // Writing to a string cannot fail.
                let _ = write!(
                    self.valid_lines,
                    "{}/{}/{}",
                    indices[0],
                    index_or_empty(indices[1]),
                    index_or_empty(indices[2])
                );
            } else {
                self.valid_lines.push_str(word);
            }
            corners += 1;
        }
        if corners < 3 {
            return Err((format!("a face with {corners} corners"), "a face needs at least 3"));
        }
        self.corner_count += corners;
        self.valid_lines.push('\n');
        Ok(())
    }

    /// Parses a face corner such as `3/1/2`, `3//2` or `-1`.
    ///
    /// Returns the indices of position, texture coordinate and normal, counted from 1; 0 for an
    /// omitted index.
    fn parse_obj_corner(&self, word: &str) -> Result<[usize; 3], MessageAndRemedy> {
        let mut indices = [0; 3];
        for (k, part) in word.split('/').enumerate() {
            if k > 2 || (part.is_empty() && k == 0) {
                let message = format!("`{}` is not a corner of a face", escaped_excerpt(word));
                return Err((message, "write v, v/vt, v//vn or v/vt/vn"));
            }
            if part.is_empty() {
                continue;
            }
            let known = self.v_vt_vn_counts_so_far[k];
            let index = match part.parse::<i64>() {
                Ok(i) if i > 0 => usize::try_from(i).ok(),
                Ok(i) if i < 0 => usize::try_from(i.unsigned_abs()).ok().and_then(|i| (known + 1).checked_sub(i)),
                _ => None,
            };
            match index {
                Some(i) if (1..=known).contains(&i) => indices[k] = i,
                _ => {
                    let message =
                        format!("`{}` names no {} ({known} stand before it)", escaped_excerpt(word), V_VT_VN_NAMES[k]);
                    return Err((message, "indices count from 1, or from -1 backwards"));
                }
            }
        }
        Ok(indices)
    }
}

/// True if `word` is a number that is finite in double precision.
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
