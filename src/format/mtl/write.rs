//! Writes materials as an MTL file for an OBJ mesh.

use super::MtlMaterial;
use crate::format::mesh::ShortestDecimal;
use crate::image::{WriteError, replace_file};
use std::fmt::Write;
use std::path::{Path, absolute};

/// Writes an MTL file. The file is written under a temporary name and then renamed, so that a
/// failure leaves an existing file unchanged.
///
/// Paths of pictures are relative to the folder of `path` if they are inside it, else absolute.
///
/// # Errors
/// [`WriteError`].
pub fn write(path: &Path, materials: &[MtlMaterial]) -> Result<(), WriteError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut text = format!("# Caustica {}\n", env!("CARGO_PKG_VERSION"));
    // Writing to a string cannot fail.
    for material in materials {
        let _ = writeln!(text, "\nnewmtl {}", material.name);
        let colours = [
            ("Kd", material.diffuse),
            ("Ks", material.specular),
            ("Ke", material.emission),
            ("Tf", material.transmission_filter),
        ];
        for (keyword, colour) in colours {
            if let Some(c) = colour {
                let _ = writeln!(
                    text,
                    "{keyword} {} {} {}",
                    ShortestDecimal(c.x),
                    ShortestDecimal(c.y),
                    ShortestDecimal(c.z)
                );
            }
        }
        for (keyword, number) in
            [("Ns", material.shininess), ("Ni", material.refractive_index), ("d", material.opacity)]
        {
            if let Some(number) = number {
                let _ = writeln!(text, "{keyword} {}", ShortestDecimal(number));
            }
        }
        if let Some(model) = material.illumination_model {
            let _ = writeln!(text, "illum {model}");
        }
        if let Some(picture) = &material.diffuse_texture_path {
            let inside = picture.strip_prefix(folder).ok();
            let named = inside.map(Path::to_owned).or_else(|| absolute(picture).ok());
            let _ = writeln!(text, "map_Kd {}", named.as_deref().unwrap_or(picture).display());
        }
    }
    replace_file(path, text.as_bytes())
}
