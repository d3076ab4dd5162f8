use super::*;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Returns a file of version 4 with two triangles: one in single and one in double precision.
fn two_meshes() -> Vec<u8> {
    let mut file = Vec::new();
    let mut offsets = Vec::new();
    for (flags, scale) in [(0x1000_u32, 1.0_f64), (0x2000 | USES_FLAT_FACES, 2.0)] {
        offsets.push(file.len() as u64);
        let mut data = flags.to_le_bytes().to_vec();
        data.extend(b"name\0");
        data.extend(3_u64.to_le_bytes());
        data.extend(1_u64.to_le_bytes());
        for x in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            let bytes = if flags & DOUBLE_PRECISION == 0 {
                ((x * scale) as f32).to_le_bytes().to_vec()
            } else {
                (x * scale).to_le_bytes().to_vec()
            };
            data.extend(bytes);
        }
        [0_u32, 1, 2].iter().for_each(|corner| data.extend(corner.to_le_bytes()));
        file.extend(SIGNATURE.to_le_bytes());
        file.extend(4_u16.to_le_bytes());
        let mut encoder = ZlibEncoder::new(&mut file, Compression::default());
        encoder.write_all(&data).unwrap();
        encoder.finish().unwrap();
    }
    offsets.iter().for_each(|offset| file.extend(offset.to_le_bytes()));
    file.extend(2_u32.to_le_bytes());
    file
}

#[test]
fn meshes_of_a_file_are_found_by_number() {
    let file = two_meshes();
    let first = decode(&file, 0, None).unwrap();
    let second = decode(&file, 1, None).unwrap();
    assert_eq!(first.mesh.positions[1], DVec3::X);
    assert_eq!(second.mesh.positions[1], 2.0 * DVec3::X);
    assert!(second.uses_flat_faces && !first.uses_flat_faces);
    assert!(decode(&file, 2, None).unwrap_err().contains("no mesh with number 2"));
    assert!(decode(&file, 0, Some(100)).unwrap_err().contains("memory"));
}

#[test]
fn damaged_meshes_are_errors_at_every_byte() {
    let file = two_meshes();
    for length in 0..file.len() {
        let _ = decode(&file[..length], 0, None);
        let _ = decode(&file[..length], 1, None);
    }
    assert!((0..40).all(|length| decode(&file[..length], 0, None).is_err()));
}
