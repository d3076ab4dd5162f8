//! Tests of the mesh reader.

use super::decode;
use glam::{DVec2, DVec3};

/// Returns a file with the given counts, three vertices, and a triangle with the given words.
pub(in crate::format::tungsten) fn triangle_file(counts: [u64; 2], triangle: [u32; 4]) -> Vec<u8> {
    let mut file = counts[0].to_le_bytes().to_vec();
    for (x, y) in [(0.0_f32, 0.0_f32), (1.0, 0.0), (0.0, 1.0)] {
        [x, y, 0.5, 0.0, 0.0, 2.0, x, y].iter().for_each(|number| file.extend(number.to_le_bytes()));
    }
    file.extend(counts[1].to_le_bytes());
    triangle.iter().for_each(|word| file.extend(word.to_le_bytes()));
    file
}

#[test]
fn vertices_and_triangles_are_those_of_the_file() {
    let mesh = decode(&triangle_file([3, 1], [0, 1, 2, 4]), None).unwrap();
    assert_eq!(mesh.positions, [DVec3::new(0.0, 0.0, 0.5), DVec3::new(1.0, 0.0, 0.5), DVec3::new(0.0, 1.0, 0.5)]);
    assert_eq!(mesh.texcoords.unwrap(), [DVec2::ZERO, DVec2::X, DVec2::Y]);
    assert_eq!(mesh.normals.unwrap().len(), 3);
    assert_eq!((mesh.triangles, mesh.triangle_materials), (vec![[0, 1, 2]], vec![4]));
}

#[test]
fn negative_materials_count_as_the_first() {
    let mesh = decode(&triangle_file([3, 1], [0, 1, 2, u32::MAX]), None).unwrap();
    assert_eq!(mesh.triangle_materials, [0]);
}

#[test]
fn a_file_that_is_cut_anywhere_is_refused() {
    let file = triangle_file([3, 1], [0, 1, 2, 0]);
    for length in 0..file.len() {
        let defect = decode(&file[..length], None).unwrap_err();
        assert!(defect.contains("the file"), "{length}: {defect}");
    }
    let longer = [&file[..], &[0]].concat();
    assert_eq!(decode(&longer, None).unwrap_err(), "the file has 129 bytes, and its mesh ends after 128");
}

#[test]
fn lying_counts_are_refused_before_memory_is_taken() {
    for counts in [[u64::MAX, 1], [1 << 59, 1], [4, 1], [2, 1], [3, u64::MAX], [3, 2], [3, 0]] {
        assert!(decode(&triangle_file(counts, [0, 1, 2, 0]), None).is_err(), "{counts:?}");
    }
    assert!(decode(&triangle_file([3, u64::MAX], [0; 4]), None).unwrap_err().contains("too short"));
}

#[test]
fn indices_out_of_range_and_numbers_that_are_not_finite_are_refused() {
    assert!(decode(&triangle_file([3, 1], [0, 1, 3, 0]), None).unwrap_err().contains("index 3 is out of range"));
    let mut file = triangle_file([3, 1], [0, 1, 2, 0]);
    file[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(decode(&file, None).unwrap_err().contains("not finite"));
}

#[test]
fn a_mesh_beyond_the_memory_limit_is_refused() {
    let file = triangle_file([3, 1], [0, 1, 2, 0]);
    assert!(decode(&file, Some(100)).unwrap_err().contains("memory"));
    assert!(decode(&file, Some(10_000)).is_ok());
}
