//! Tests of grid files: their syntax, and the refusal of damaged files.

use super::*;
use proptest::prelude::*;

fn call_with_temporary_file<T>(bytes: &[u8], then: impl FnOnce(&Path) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.grid");
    std::fs::write(&path, bytes).unwrap();
    then(&path)
}

fn read_grid_bytes(bytes: &[u8]) -> Result<DensityGridData, GridError> {
    call_with_temporary_file(bytes, read)
}

fn grid_file_bytes(grid: &DensityGridData, encoding: GridEncoding) -> Vec<u8> {
    call_with_temporary_file(&[], |path| {
        write(path, grid, encoding).unwrap();
        std::fs::read(path).unwrap()
    })
}

/// Asserts that reading `bytes` fails, with an error that contains `place`, `message` and `remedy`.
#[track_caller]
fn assert_refused(bytes: &[u8], place: &str, message: &str, remedy: &str) {
    let error = read_grid_bytes(bytes).unwrap_err().to_string();
    assert!(error.contains(&format!("a.grid:{place}")), "`{place}` is not in `{error}`");
    assert!(error.contains(message) && error.contains(remedy), "{error}");
}

#[test]
fn grid_values_are_text_or_f32_x_fastest() {
    let grid = DensityGridData { cell_counts: [3, 2, 1], densities: vec![0.0, 1.0, 2.5, 3.0, 1e-30, 5e7] };
    let text = b"caustica-grid 1\r\n# smoke\r\ntype text\r\nsize 3 2 1\r\n\r\n0 1 2.5\n3\t1e-30\r\n\n  5e7 ";
    assert_eq!(read_grid_bytes(text).unwrap(), grid);
    let mut singles = b"caustica-grid 1\nsize 3 2 1\ntype f32\n\n".to_vec();
    singles.extend(grid.densities.iter().flat_map(|v| v.to_le_bytes()));
    assert_eq!(read_grid_bytes(&singles).unwrap(), grid);
    assert_eq!(grid_file_bytes(&grid, GridEncoding::F32), singles);
    assert_eq!(
        read_grid_bytes(b"caustica-grid 1\ntype text\nsize 1 1 1\n\n7").unwrap(),
        DensityGridData { cell_counts: [1; 3], densities: vec![7.0] }
    );
}

#[test]
fn grid_headers_are_checked_by_line() {
    assert_refused(b"", "1", "no empty line", "at most 4096 bytes");
    assert_refused(b"P5\n", "1", "this is no grid", "`caustica-grid 1`");
    assert_refused(b"\xff\xfe\n", "1", "this is no grid", "`caustica-grid 1`");
    assert_refused(b" BDV\0\0", "1", "OpenVDB", "sample it on a grid");
    assert_refused(b"caustica-grid 2\n", "1", "this version is not known", "version 1");
    let body = |lines: &str| format!("caustica-grid 1\n{lines}").into_bytes();
    assert_refused(&body("size 1 1\n"), "2", "says nothing of a grid", "`size NX NY NZ`");
    assert_refused(&body("size 1 1 1\nsize 1 1 1\n"), "3", "says nothing of a grid", "each once");
    assert_refused(&body("size 1 0 1\n"), "2", "`0` is no number of cells", "whole numbers from 1 on");
    assert_refused(&body("size 1 -1 1\n"), "2", "`-1` is no number of cells", "whole numbers");
    assert_refused(&body("size 1 1 4294967296\n"), "2", "`4294967296` is no number of cells", "whole numbers");
    assert_refused(&body("type f64\n"), "2", "this type is not known", "`type f32` or `type text`");
    assert_refused(&body("type text\n\n"), "3", "the size is missing", "ahead of the empty line");
    assert_refused(&body("size 1 1 1\n\n"), "3", "the type is missing", "ahead of the empty line");
    assert_refused(&body("# \nsize 1 1 1"), "3", "no empty line", "at most 4096 bytes");
    let long = format!("size 1 1 1\ntype text\n{}\n1", "# very long\n".repeat(400));
    assert_refused(&body(&long), "", "no empty line", "at most 4096 bytes");
}

#[test]
fn grid_sizes_must_match_the_file_length() {
    let body = |size: &str, kind: &str| format!("caustica-grid 1\nsize {size}\ntype {kind}\n\n1 1").into_bytes();
    assert_refused(&body("4294967295 4294967295 4294967295", "f32"), "2", "are too many", "at most 2³⁰");
    assert_refused(&body("1025 1024 1024", "f32"), "2", "are too many", "at most 2³⁰");
    assert_refused(
        &body("1024 1024 1024", "f32"),
        " 3 bytes",
        "1024 × 1024 × 1024 cells of type f32 take 4294967296",
        "correct its size",
    );
    assert_refused(
        &body("1024 1024 1024", "text"),
        "4",
        "at most 2 numbers follow, but the size asks for 1073741824",
        "one number for each",
    );
    assert_refused(&body("1 1 1", "f32"), " 3 bytes", "take 4", "correct its size");
}

#[test]
fn text_grids_hold_one_number_per_cell() {
    let body = |words: &str| format!("caustica-grid 1\nsize 2 1 2\ntype text\n\n{words}").into_bytes();
    assert_refused(&body("1 2\n3      "), "6", "3 numbers follow, but the size asks for 4", "x running fastest");
    assert_refused(&body("1 2\n3 4\n5"), "7", "more than 4 numbers follow", "nothing behind them");
    assert_refused(&body("1 2\n3 four"), "6", "`four` is no number", "parted by spaces or lines");
    assert_refused(&body("1 2,\n3 4"), "5", "`2,` is no number", "parted by spaces or lines");
    assert_refused(b"caustica-grid 1\nsize 1 1 1\ntype text\n\n\xff", "5", "is no number", "parted by spaces or lines");
}

#[test]
fn invalid_densities_are_reported_by_cell() {
    for (bad, shown) in [(-1.0, "-1"), (f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        let mut values = vec![1.0; 24];
        // This is the cell (1, 2, 3) of a grid of 2 × 3 × 4 cells.
        values[1 + 2 * (2 + 3 * 3)] = bad;
        for encoding in [GridEncoding::F32, GridEncoding::Text] {
            let bytes =
                grid_file_bytes(&DensityGridData { cell_counts: [2, 3, 4], densities: values.clone() }, encoding);
            assert_refused(&bytes, " the density of cell (1, 2, 3)", &format!("is {shown}"), "finite and at least 0");
        }
    }
    assert_refused(b"caustica-grid 1\nsize 1 1 1\ntype text\n\n1e99", "", "is inf", "finite");
}

#[test]
fn unreadable_grid_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_owned(), folder.path().join("none")] {
        let error = read(&path).unwrap_err();
        assert!(
            matches!(error, GridError::Unreadable { .. }) && error.to_string().contains("check that it"),
            "{error}"
        );
    }
}

fn any_grid() -> impl Strategy<Value = DensityGridData> {
    let value = prop_oneof![Just(0.0), proptest::num::f32::POSITIVE | proptest::num::f32::SUBNORMAL];
    ([1..5_u32, 1..5_u32, 1..5_u32], proptest::collection::vec(value, 64)).prop_map(|(size, mut values)| {
        values.truncate(size.iter().product::<u32>() as usize);
        DensityGridData { cell_counts: size, densities: values.into_iter().map(f32::abs).collect() }
    })
}

fn any_grid_encoding() -> impl Strategy<Value = GridEncoding> {
    prop_oneof![Just(GridEncoding::F32), Just(GridEncoding::Text)]
}

proptest! {
    #[test]
    fn grids_read_back_bit_for_bit(grid in any_grid(), encoding in any_grid_encoding()) {
        prop_assert_eq!(read_grid_bytes(&grid_file_bytes(&grid, encoding)).unwrap(), grid);
    }

    /// Text files that lose only their last digits still hold all values. All other damage is
    /// refused.
    #[test]
    fn truncated_or_longer_grid_files_are_refused(grid in any_grid(), encoding in any_grid_encoding(), at in any::<prop::sample::Index>()) {
        let bytes = grid_file_bytes(&grid, encoding);
        let cut = read_grid_bytes(&bytes[..at.index(bytes.len())]);
        prop_assert!(cut.is_err() || (encoding == GridEncoding::Text && cut.unwrap().densities.len() == grid.densities.len()));
        let more: &[u8] = if encoding == GridEncoding::F32 { &[0] } else { b" 1" };
        prop_assert!(read_grid_bytes(&[&bytes, more].concat()).is_err());
    }

    #[test]
    fn the_reader_never_panics(grid in any_grid(), encoding in any_grid_encoding(), at in any::<prop::sample::Index>(), new in any::<[u8; 3]>()) {
        let mut bytes = grid_file_bytes(&grid, encoding);
        let at = at.index(bytes.len());
        let end = bytes.len().min(at + 3);
        bytes[at..end].copy_from_slice(&new[..end - at]);
        match read_grid_bytes(&bytes) {
            Ok(read) => prop_assert!(read.densities.iter().all(|v| v.is_finite() && *v >= 0.0)),
            Err(error) => prop_assert!(error.to_string().contains("a.grid")),
        }
    }
}
