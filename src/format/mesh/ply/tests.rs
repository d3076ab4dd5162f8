use super::*;
use crate::format::mesh::TriangleMesh;

const VERTEX: &str = "property float x\nproperty float y\nproperty float z\n";
const FACE: &str = "property list uchar int vertex_indices\n";

fn read_ply_bytes(bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    read(Path::new("a.ply"), bytes, &(), None).map(|loaded| loaded.mesh)
}

fn ply_header_text(encoding: &str, vertices: impl std::fmt::Display, faces: impl std::fmt::Display) -> String {
    let (v, f) = (format!("element vertex {vertices}\n{VERTEX}"), format!("element face {faces}\n{FACE}"));
    format!("ply\nformat {encoding} 1.0\n{v}{f}end_header\n")
}

fn read_ascii_body(vertices: usize, faces: usize, body: &str) -> Result<TriangleMesh, MeshError> {
    read_ply_bytes(format!("{}{body}", ply_header_text("ascii", vertices, faces)).as_bytes())
}

#[track_caller]
fn assert_refused(bytes: &[u8], message: &str) {
    let error = read_ply_bytes(bytes).unwrap_err().to_string();
    assert!(error.contains(message), "`{message}` is not in `{error}`");
    assert!(error.starts_with("a.ply:") && error.matches(": ").count() >= 2, "{error}");
}

const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

#[test]
fn polygons_are_triangulated_as_fans() {
    let mesh = read_ascii_body(4, 2, &format!("{SQUARE}4 0 1 2 3\n3 0 2 3\n")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 2, 3]]);
    assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
    // Any white space separates numbers.
    assert_eq!(read_ascii_body(4, 1, "0 0 0 1\r\n0 0 1 1 0\t0 1 0 4 0 1 2\n3").unwrap().triangles.len(), 2);
}

#[test]
fn every_number_type_is_read_in_both_endians() {
    let types: [(&str, &[u8]); 16] = [
        ("char", &[3]),
        ("int8", &[3]),
        ("uchar", &[3]),
        ("uint8", &[3]),
        ("short", &[0, 3]),
        ("int16", &[0, 3]),
        ("ushort", &[0, 3]),
        ("uint16", &[0, 3]),
        ("int", &[0, 0, 0, 3]),
        ("int32", &[0, 0, 0, 3]),
        ("uint", &[0, 0, 0, 3]),
        ("uint32", &[0, 0, 0, 3]),
        ("float", &[0x40, 0x40, 0, 0]),
        ("float32", &[0x40, 0x40, 0, 0]),
        ("double", &[0x40, 8, 0, 0, 0, 0, 0, 0]),
        ("float64", &[0x40, 8, 0, 0, 0, 0, 0, 0]),
    ];
    for (name, three) in types {
        for (encoding, big) in [("binary_big_endian", true), ("binary_little_endian", false)] {
            let bytes: Vec<u8> = if big { three.to_vec() } else { three.iter().rev().copied().collect() };
            let zero = vec![0; bytes.len()];
            // Vertices at distance 3 on each axis and at the origin. Then an element to skip with a
            // list of this type, and a face with index lists of this type.
            let whole = !name.starts_with(['f', 'd']);
            let index = if whole { name } else { "uchar" };
            let mut text = format!("ply\nformat {encoding} 1.0\nelement vertex 4\n").into_bytes();
            for axis in ["x", "y", "z"] {
                text.extend(format!("property {name} {axis}\n").bytes());
            }
            text.extend(
                format!("element other 1\nproperty list uchar {name} skipped\nproperty {name} skipped\n").bytes(),
            );
            text.extend(
                format!("element face 1\nproperty {name} s\nproperty list {index} {index} vertex_index\n").bytes(),
            );
            text.extend(b"end_header\n");
            for corner in [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]] {
                for one in corner {
                    text.extend(if one == 1 { &bytes } else { &zero });
                }
            }
            text.extend([[2].as_slice(), &bytes, &zero, &bytes].concat());
            let number = |n: u8| {
                let mut wide = vec![0; if whole { bytes.len() } else { 1 }];
                let at = if big { wide.len() - 1 } else { 0 };
                wide[at] = n;
                wide
            };
            text.extend(&bytes);
            for n in [3, 3, 0, 1] {
                text.extend(number(n));
            }
            let mesh = read_ply_bytes(&text).unwrap();
            assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0], "{name} {encoding}");
            // The file is refused if it is cut off at any byte.
            for end in 0..text.len() {
                assert!(read_ply_bytes(&text[..end]).is_err(), "{name} {encoding} {end}");
            }
        }
    }
}

#[test]
fn normals_and_texcoords_are_found_by_property_name() {
    for (s, t) in [("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t")] {
        let text = format!(
            "ply\r\nformat ascii 1.0\r\ncomment end_header\r\nobj_info x\r\nelement vertex 3\r\nproperty double {t}\r\n\
             property float nz\r\n{VERTEX}property float nx\r\nproperty float ny\r\nproperty double {s}\r\n\
             property list uchar float more\r\nelement face 1\r\n{FACE}end_header\r\n\
             .5 2 0 0 0 0 0 .25 0\r\n.5 2 1 0 0 0 0 .25 2 1 1\r\n.5 2 0 1 0 0 0 .25 0\r\n3 0 1 2\r\n"
        );
        let mesh = read_ply_bytes(text.as_bytes()).unwrap();
        assert_eq!(mesh.normals.unwrap(), [DVec3::Z; 3]);
        assert_eq!(mesh.texcoords.unwrap(), [DVec2::new(0.25, 0.5); 3]);
        assert_eq!(mesh.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    }
    let half = format!("ply\nformat ascii 1.0\nelement vertex 3\n{VERTEX}property float nx\nproperty float s\n");
    let half = format!("{half}element face 1\n{FACE}end_header\n0 0 0 1 1 1 0 0 1 1 0 1 0 1 1 3 0 1 2");
    let mesh = read_ply_bytes(half.as_bytes()).unwrap();
    assert_eq!((mesh.normals, mesh.texcoords), (None, None));
}

#[test]
fn faces_may_precede_vertices() {
    let text = format!(
        "ply\nformat ascii 1.0\nelement face 1\n{FACE}element empty 18446744073709551615\nelement vertex 3\n{VERTEX}end_header\n\
         3 0 1 2 0 0 0 1 0 0 0 1 0"
    );
    assert_eq!(read_ply_bytes(text.as_bytes()).unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn invalid_headers_are_reported_by_line() {
    let with = |line: &str| format!("ply\nformat ascii 1.0\n{line}\nend_header\n");
    for (line, message) in [
        ("element vertex -1", "a.ply:3: `-1` is no count"),
        ("element vertex 1e3", "a.ply:3: `1e3` is no count"),
        ("element vertex", "a.ply:3: `` is no count"),
        ("property float x", "a.ply:3: a property stands before any element"),
        ("element vertex 3\nproperty float x\nproperty float y", "a.ply:3: `vertex` lacks one of"),
        ("element face 3\nproperty float x", "a.ply:3: `face` has no list"),
        ("element face 3\nproperty int vertex_indices", "a.ply:3: `face` has no list"),
        (&format!("element face 3\n{FACE}property list uchar int vertex_index"), "a.ply:3: `face` has two lists"),
        ("element vertex 3\nproperty half x", "a.ply:4: `half` is no type"),
        ("element vertex 3\nproperty list float int x", "a.ply:4: the length of the list `x`"),
        ("element face 3\nproperty list uchar float vertex_index", "a.ply:4: the indices `vertex_index`"),
        ("element face 3\nproperty list uchar", "a.ply:4: `` is no type"),
        ("format spoken 1.0", "a.ply:3: unknown format `spoken`"),
        ("\u{1b}[31m", "is no line of a PLY header"),
    ] {
        assert_refused(with(line).as_bytes(), message);
    }
    assert_refused(b"ply\nend_header\n", "names no format");
    assert_refused(b"ply\nformat ascii 1.0\nelement vertex 3", "a.ply:3: the header ends without");
    assert_refused(b"", "a.ply:1: the header ends without");
    assert_refused(b"v 0 0 0\n", "a.ply:1: the first line is not `ply`");
    let twice = format!("element vertex 0\n{VERTEX}element vertex 0");
    assert_refused(with(&twice).as_bytes(), "`vertex` is declared twice");
}

#[test]
fn oversized_counts_are_refused() {
    for count in ["4", "4294967295", "18446744073709551615"] {
        for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let body = if encoding == "ascii" { "0 0 0 1 0 0 0 1 0 3 0 1 2".as_bytes() } else { &[0; 49] };
            let text = |v: &str, f: &str| [ply_header_text(encoding, v, f).as_bytes(), body].concat();
            assert_refused(&text(count, "1"), "a.ply:");
            assert_refused(
                &text(count, "1"),
                if count == "4" { "" } else { "a.ply:3: 4294967295" }.split(' ').next().unwrap(),
            );
            assert_refused(&text("3", "4294967295"), "a.ply:7: 4294967295 times `face` need");
        }
    }
    // The face states 4294967295 corners, or a negative number of corners.
    let start = format!("ply\nformat binary_little_endian 1.0\nelement vertex 1\n{VERTEX}element face 1\n");
    let listed = |count: &str, n: u8| {
        let header = format!("{start}property list {count} int vertex_indices\nend_header\n");
        [header.as_bytes(), &[0; 12], &[n; 4], &[0; 40]].concat()
    };
    assert_refused(
        &listed("uint", 0xff),
        "face 0: a list of 4294967295 entries, but the rest of the file holds at most 10",
    );
    assert_refused(&listed("int", 0xff), "face 0: a face with -1 corners");
    assert_refused(&listed("char", 0xff), "a face with -1 corners");
    assert_refused(&listed("uchar", 2), "a face with 2 corners");
}

#[test]
fn invalid_bodies_are_reported_with_position() {
    let ascii = |body: &str| format!("{}{body}", ply_header_text("ascii", 4, 1));
    for (body, message) in [
        ("0 0 0\n1 0 nan\n0 0 0\n0 0 0\n3 0 1 2", "a.ply:11: `z` is NaN"),
        ("0 0 0\n1 0 1e99\n0 0 0\n0 0 0\n3 0 1 2", "a.ply:11: `z` is inf"),
        ("0 0 0\n1 0 x\n0 0 0\n0 0 0\n3 0 1 2", "a.ply:11: `x` is not a number"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 4", "a.ply:14: there is no vertex 4: the file has 4"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 -1", "there is no vertex -1"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 1.5", "`1.5` is not a number"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 99999999999999999999", "is not a number"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 1    ", "a face with 2 corners"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n-3 0 1 2", "a face with -3 corners"),
        ("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1      ", "the file ends here"),
    ] {
        assert_refused(ascii(body).as_bytes(), message);
    }
    let binary = |x: f32, index: i32| {
        let mut bytes = ply_header_text("binary_little_endian", 1, 1).into_bytes();
        bytes.extend([x.to_le_bytes(), [0; 4], [0; 4]].concat());
        bytes.extend([[3].as_slice(), &[0; 8], &index.to_le_bytes()].concat());
        bytes
    };
    assert_eq!(read_ply_bytes(&binary(1.0, 0)).unwrap().triangles, [[0; 3]]);
    let start = ply_header_text("binary_little_endian", 1, 1).len();
    assert_refused(&binary(f32::NAN, 0), &format!("a.ply: byte {start}, vertex 0: `x` is NaN"));
    assert_refused(&binary(1.0, 1), &format!("a.ply: byte {}, face 0: there is no vertex 1", start + 12));
    assert_refused(&binary(1.0, -1), "there is no vertex -1");
}

#[test]
fn lists_longer_than_the_file_are_malformed() {
    // The error is that the file is too short for its list, not that the list exceeds the memory.
    let text = format!("{}{SQUARE}4000000000 0 1 2\n", ply_header_text("ascii", 4, 1).replace("uchar int", "uint int"));
    let error = read(Path::new("a.ply"), text.as_bytes(), &(), Some(100_000)).unwrap_err().to_string();
    assert!(error.contains("a list of 4000000000 entries") && error.contains("cut short"), "{error}");
    let skipped = "property list uint float weights\n";
    let text = format!("ply\nformat ascii 1.0\nelement vertex 1\n{VERTEX}{skipped}end_header\n0 0 0 9 1 1\n");
    assert_refused(text.as_bytes(), "a list of 9 entries");
}

#[test]
fn byte_order_marks_are_skipped() {
    for encoding in ["ascii", "binary_little_endian"] {
        let body: &[u8] = if encoding == "ascii" { b"0 0 0 1 0 0 0 1 0 3 0 1 2" } else { &[3; 49] };
        let plain = [ply_header_text(encoding, 3, 1).as_bytes(), body].concat();
        let marked = [b"\xef\xbb\xbf".as_slice(), &plain].concat();
        let decoded = |bytes: &[u8]| crate::format::mesh::decode(Path::new("a"), bytes.to_vec(), &(), None);
        if encoding == "ascii" {
            assert_eq!(decoded(&marked).unwrap(), decoded(&plain).unwrap());
        } else {
            assert_eq!(decoded(&marked).unwrap_err().to_string(), decoded(&plain).unwrap_err().to_string());
        }
    }
}

#[test]
fn non_utf8_bytes_are_refused() {
    let bytes = [ply_header_text("ascii", 3, 1).as_bytes(), b"0 0 0 1 0 0 0 1 0 3 0 \xff 2"].concat();
    assert_refused(&bytes, "a.ply:10: there are bytes here that are no text");
}

proptest::proptest! {
    #[test]
    fn the_reader_never_panics(
        words in proptest::collection::vec(
            "element (vertex|face|x) [0-9]{1,20}\n|property (list (u?char|u?int) )?(u?char|int|float|double) (x|y|z|nx|s|vertex_index)\n\
             |format (ascii|binary_(little|big)_endian) 1.0\n|end_header\n|[0-9. -]{0,20}|.{0,3}", 0..24),
        bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..80),
    ) {
        let _ = read_ply_bytes(&[b"ply\nformat binary_little_endian 1.0\n", words.concat().as_bytes(), &bytes].concat());
        let _ = read_ply_bytes(&[b"ply\n", words.concat().as_bytes(), &bytes].concat());
    }

    #[test]
    fn a_changed_byte_never_panics_the_reader(at in proptest::num::usize::ANY, new in proptest::num::u8::ANY) {
        for encoding in ["ascii", "binary_little_endian"] {
            let body: &[u8] = if encoding == "ascii" { b"0 0 0 1 0 0 0 1 0 3 0 1 2" } else { &[0; 49] };
            let mut bytes = [ply_header_text(encoding, 3, 1).as_bytes(), body].concat();
            let at = at % bytes.len();
            bytes[at] = new;
            let _ = read_ply_bytes(&bytes);
            let _ = read_ply_bytes(&bytes[..at]);
        }
    }
}

/// A face corner that takes one byte in the file takes 32 bytes in memory. Reading must check the
/// limit before it allocates them.
#[test]
fn face_memory_is_checked_before_allocation() {
    let head = format!("ply\nformat binary_little_endian 1.0\nelement vertex 4\n{VERTEX}element face 1\n");
    let mut file = format!("{head}property list uint uchar vertex_indices\nend_header\n").into_bytes();
    file.extend([0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
    file.extend(1_000_000_u32.to_le_bytes());
    file.extend((0..1_000_000_u32).map(|i| (i % 4) as u8));
    let reading = |free| read(Path::new("a.ply"), &file, &(), Some(free));
    assert_eq!(reading(33_000_000).unwrap().mesh.triangles.len(), 999_998);
    match reading(31_000_000) {
        Err(MeshError::OutOfMemory { needed, free: 31_000_000, .. }) => assert!(needed > 31_999_000, "{needed}"),
        other => panic!("{other:?}"),
    }
    // Reading of a text file with many faces also keeps to the limit.
    let body = "3 0 1 2\n4 0 1 2 3\n".repeat(1000);
    let file = format!("{}{SQUARE}{body}", ply_header_text("ascii", 4, 2000)).into_bytes();
    let reading = |free| read(Path::new("a.ply"), &file, &(), Some(free));
    assert!(reading(73_000).is_ok() && matches!(reading(71_000), Err(MeshError::OutOfMemory { .. })));
}
