//! Meshes from files: read once, smoothed where asked, and parted by what they are made of.

use super::{Resolver, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{MeshOptions, Spanned};
use crate::format::mesh::{self, Loaded, MeshError, NO_MATERIAL};
use crate::format::mtl;
use crate::math::Transform;
use std::path::{Path, PathBuf};
use std::rc::Rc;

const MEND: &str = "mend the mesh or name another";

/// A file, whether its normals are left out, and the bits of the angle up to which it is smoothed.
pub(super) type Key = (PathBuf, bool, Option<u64>);

/// A material of a mesh's own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own {
    index: u32,
    emission: Rgb,
}

impl Resolver<'_> {
    /// Adds the mesh of a file: `told` is the emission that the scene gives it, `emission` that or its material's.
    pub(super) fn mesh(
        &mut self,
        map: &Transform,
        path: &Spanned<String>,
        options: MeshOptions,
        told: Option<Rgb>,
        emission: Rgb,
    ) -> Result<(), SceneError> {
        let file = self.file("mesh", path)?;
        let loaded = self.loaded(&file, options).map_err(|e| self.bad_file(path, &e, MEND))?;
        let (whole, scene_material) = (&loaded.mesh, self.material);
        if !options.own_materials || whole.materials.is_empty() {
            let normals = whole.normals.as_deref();
            self.place_mesh(map, &whole.positions, normals, &whole.triangles, scene_material, emission);
            return Ok(());
        }
        let own = self.own_materials(path, &file, &loaded)?;
        for (number, part) in whole.parts() {
            let (material, emission) = match own.get(number as usize) {
                Some(own) if number != NO_MATERIAL => (own.index, told.unwrap_or(own.emission)),
                _ => (scene_material, emission),
            };
            let normals = part.normals.as_deref();
            self.place_mesh(map, &part.positions, normals, &part.triangles, material, emission);
        }
        Ok(())
    }

    fn loaded(&mut self, file: &Path, options: MeshOptions) -> Result<Rc<Loaded>, MeshError> {
        let key = (file.to_owned(), options.no_normals, options.smooth_angle.map(f64::to_bits));
        if let Some(loaded) = self.meshes.get(&key) {
            return Ok(loaded.clone());
        }
        let mut loaded = mesh::load(file, self.monitor)?;
        if options.no_normals {
            loaded.mesh.normals = None;
        }
        if let Some(angle) = options.smooth_angle {
            loaded.mesh.smooth(angle);
        }
        let loaded = Rc::new(loaded);
        self.meshes.insert(key, loaded.clone());
        Ok(loaded)
    }

    /// The materials that the mesh of a file names.
    fn own_materials(
        &mut self,
        path: &Spanned<String>,
        file: &Path,
        loaded: &Loaded,
    ) -> Result<Rc<Vec<Own>>, SceneError> {
        if let Some(own) = self.own_materials.get(file) {
            return Ok(own.clone());
        }
        let library = mtl::of_mesh(file, loaded).map_err(|e| self.bad_file(path, &e, MEND))?;
        let mut own = Vec::with_capacity(library.len());
        for found in library {
            let bad = |(message, remedy)| MeshError::BadMaterial { path: file.into(), message, remedy };
            let meaning = found.meaning().map_err(|e| self.bad_file(path, &bad(e), MEND))?;
            let material = self.material(&meaning.kind, &[])?;
            let emission = meaning.emission.map_or(Rgb::ZERO, rgb);
            own.push(Own { index: self.builder.material(material), emission });
        }
        let own = Rc::new(own);
        self.own_materials.insert(file.to_owned(), own.clone());
        Ok(own)
    }
}
