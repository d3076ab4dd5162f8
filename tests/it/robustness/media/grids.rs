//! Density grids with invalid cells are refused.

use caustica::format::SceneFile;
use caustica::medium::{GridDensity, GridDensityError};
use glam::DAffine3;
use std::fs;

const SCENE: &str = "\
PerspectiveCamera { center 0 0 5 lookAt 0 0 0 angle 30 width 4 height 4 }
Media { Medium fog { scattering 1 1 1 grid a.grid min 0 0 0 max 1 1 1 } }
Materials { Clear air { medium fog } }
Group { MaterialName air Sphere { center 0 0 0 radius 1 } }
";

/// A negative or non-finite cell is refused with its index, wherever it is in the grid.
///
/// For a grid built in code, the error names the cell. For a grid file, the error also points at
/// the file name in the scene and names a remedy.
#[test]
fn invalid_density_cells_are_refused_with_index() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("a.txt");
    fs::write(&scene, SCENE).unwrap();
    let put = |values: &[f32]| {
        let words: Vec<String> = values.iter().map(f32::to_string).collect();
        let text = format!("caustica-grid 1\nsize 2 3 4\ntype text\n\n{}", words.join(" "));
        fs::write(folder.path().join("a.grid"), text).unwrap();
        SceneFile::read(&scene).unwrap().resolve()
    };
    put(&[0.5; 24]).unwrap();
    put(&[-0.0; 24]).unwrap();
    for bad in [-1e-30f32, -1.0, f32::MIN, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for cell in [0usize, 7, 23] {
            let mut values = vec![0.5f32; 24];
            values[cell] = bad;
            let (column, row, layer) = (cell % 2, cell / 2 % 3, cell / 6);
            let refused = GridDensity::new([2, 3, 4], values.clone(), DAffine3::IDENTITY).unwrap_err();
            let GridDensityError::InvalidDensity { x, y, z, value } = refused else { panic!("{refused}") };
            assert_eq!((x as usize, y as usize, z as usize, value.to_bits()), (column, row, layer, bad.to_bits()));
            let error = put(&values).unwrap_err();
            let place = format!("cell ({column}, {row}, {layer})");
            assert!(error.message().contains(&place) && error.message().contains("at least 0"), "{error}");
            assert_eq!((error.line(), error.offending_text()), (2, "a.grid"));
            assert!(error.remedy().contains("repair the grid"), "{}", error.remedy());
        }
    }
}
