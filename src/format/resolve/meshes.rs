//! Meshes from files: read once, smoothed where asked, and parted by what they are made of.

use super::shapes::Instanced;
use super::textures::Worn;
use super::{Resolver, rgb};
use crate::color::Rgb;
use crate::format::SceneError;
use crate::format::description::{Emission, Material, MaterialKind, MeshOptions, Span, Spanned};
use crate::format::mesh::{self, Loaded, MeshError, NO_MATERIAL, TriangleMesh};
use crate::format::mtl;
use crate::math::{Motion, Transform};
use crate::shape::Form;
use crate::stats::bytes;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Copies of a mesh share its triangles where that saves so many.
const WORTH_SHARING: usize = 50_000;

const MEND: &str = "mend the mesh or name another";

/// Bytes that a placed triangle takes at most while the tree over it is built, with its corners, which two triangles share on average,
/// their normals and texture coordinates: 436 to 482 as measured on grids of a million.
const PER_TRIANGLE: u64 = 500;

/// A file, whether its own materials are used, whether its normals are left out, and the bits of the angle that it is smoothed to.
pub(super) type Key = (PathBuf, bool, bool, Option<u64>);

/// What an object sends out.
pub(super) struct EmissionOverride {
    /// Its radiance, or the mean of it.
    pub radiance: Rgb,
    /// Whether that is the object's own rather than its material's.
    pub told: bool,
    /// The texture that it follows, and what that is multiplied by.
    pub glow: Option<(u32, Rgb)>,
}

/// Where a mesh is placed.
pub(super) struct Placing<'p> {
    pub to_world: &'p Motion,
    /// When the shutter opens.
    pub map: &'p Transform,
    pub span: Span,
    pub shine: &'p EmissionOverride,
}

/// The parts of a mesh by their materials.
pub(super) struct Pieces {
    list: Vec<Piece>,
}

struct Piece {
    mesh: Rc<TriangleMesh>,
    /// Its own material; `None` where it has the scene's.
    own: Option<Own>,
}

/// A material of a mesh's own.
#[derive(Clone, Debug)]
pub(super) struct Own {
    name: Rc<str>,
    index: u32,
    emission: Rgb,
}

impl Resolver<'_> {
    /// Adds the mesh of a file.
    pub(super) fn mesh(
        &mut self,
        placing: &Placing<'_>,
        path: &Spanned<String>,
        options: MeshOptions,
    ) -> Result<(), SceneError> {
        let pieces = self.pieces(path, options)?;
        let again = self.uses.get(path.as_str()).map_or(0, |n| n - 1);
        let in_force = self.material;
        for Piece { mesh, own } in &pieces.list {
            let emission = match own {
                Some(own) if !placing.shine.told => own.emission,
                _ => placing.shine.radiance,
            };
            self.material = own.as_ref().map_or(in_force, |own| own.index);
            let name = own.as_ref().map(|own| &*own.name);
            self.check_coordinates(mesh.texcoords.is_some(), path, name)?;
            self.piece(path, placing, mesh, again, emission)?;
            if let (Some((texture, scale)), None) = (placing.shine.glow, own) {
                self.builder.glow(texture, scale);
            }
        }
        self.material = in_force;
        Ok(())
    }

    /// Adds triangles of the material in force, of which there are copies `again` so many times.
    fn piece(
        &mut self,
        path: &Spanned<String>,
        placing: &Placing<'_>,
        mesh: &Rc<TriangleMesh>,
        again: usize,
        emission: Rgb,
    ) -> Result<(), SceneError> {
        let (normals, texcoords) = (mesh.normals.as_deref(), mesh.texcoords.as_deref());
        let shared = emission == Rgb::ZERO && again * mesh.triangles.len() >= WORTH_SHARING;
        let instanced = shared || !placing.to_world.is_still();
        // Copies that share their triangles share the tree over them.
        if !(instanced && self.instanced.contains_key(&Rc::as_ptr(mesh))) {
            self.check_trees(path, mesh.triangles.len())?;
        }
        if instanced {
            let instance = self
                .instanced
                .entry(Rc::as_ptr(mesh))
                .or_insert_with(|| Rc::new(Instanced::new(&mesh.positions, normals, texcoords, &mesh.triangles)));
            let instance = Rc::clone(instance);
            self.place_instance(&instance, placing.to_world, placing.map, placing.span, emission)?;
        } else {
            self.place_mesh(placing.map, &mesh.positions, normals, &mesh.triangles, emission);
            self.lay_corners(texcoords);
        }
        self.lay(Form::Uv, placing.to_world);
        Ok(())
    }

    /// Counts triangles that a tree will be built over, where memory suffices for all so far.
    fn check_trees(&mut self, path: &Spanned<String>, triangles: usize) -> Result<(), SceneError> {
        self.triangles += triangles as u64;
        let needed = PER_TRIANGLE * self.triangles;
        let Some(free) = self.memory.free().filter(|free| needed > *free) else { return Ok(()) };
        let (needed, free) = (bytes(needed), bytes(free));
        let message = format!(
            "the scene has {} triangles with this mesh, which take {needed} of memory, and {free} are free",
            self.triangles
        );
        let help = "simplify meshes, or let the scene have more memory (--memory)";
        Err(self.bad_file(path, &message, help).exhausting())
    }

    /// The parts of the mesh of a path, read once.
    fn pieces(&mut self, path: &Spanned<String>, options: MeshOptions) -> Result<Rc<Pieces>, SceneError> {
        let file = self.file("mesh", path)?;
        let MeshOptions { own_materials, no_normals, smooth_angle } = options;
        let key = (file.clone(), own_materials, no_normals, smooth_angle.map(f64::to_bits));
        if let Some(pieces) = self.meshes.get(&key) {
            return Ok(pieces.clone());
        }
        let loaded = match self.assets.meshes.get(path.as_str()) {
            Some(mesh) => Ok(Loaded { mesh: (**mesh).clone(), ..Loaded::default() }),
            None => mesh::load_within(&file, self.monitor, self.memory.free()),
        };
        let mut loaded = loaded.map_err(|e| self.refuse_file(path, &e, matches!(e, MeshError::Memory { .. }), MEND))?;
        if no_normals {
            loaded.mesh.normals = None;
        }
        if let Some(angle) = smooth_angle {
            loaded.mesh.smooth(angle);
        }
        let mut list = Vec::new();
        if own_materials && !loaded.mesh.materials.is_empty() {
            let own = self.own_materials(path, &file, &loaded)?;
            for (number, part) in loaded.mesh.parts() {
                let own = own.get(number as usize).cloned().filter(|_| number != NO_MATERIAL);
                list.push(Piece { mesh: Rc::new(part), own });
            }
        } else {
            list.push(Piece { mesh: Rc::new(loaded.mesh), own: None });
        }
        let pieces = Rc::new(Pieces { list });
        self.meshes.insert(key, pieces.clone());
        Ok(pieces)
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
        let library = mtl::of_mesh(file, loaded, self.memory.free());
        let library = library.map_err(|e| self.refuse_file(path, &e, matches!(e, MeshError::Memory { .. }), MEND))?;
        let mut own = Vec::with_capacity(library.len());
        for found in library {
            let bad = |(message, remedy)| MeshError::BadMaterial { path: file.into(), message, remedy };
            let meaning = found.meaning().map_err(|e| self.bad_file(path, &bad(e), MEND))?;
            own.push(self.own_material(path, meaning)?);
        }
        let own = Rc::new(own);
        self.own_materials.insert(file.to_owned(), own.clone());
        Ok(own)
    }

    /// Adds a material of a mesh's own; errors show where the mesh is named.
    fn own_material(&mut self, path: &Spanned<String>, mut meaning: Material) -> Result<Own, SceneError> {
        if let MaterialKind::Phong { texture: Some(picture), .. } = &mut meaning.kind {
            picture.span = path.span;
        }
        let mut worn = Worn::default();
        let (material, coat) = self.material(&meaning.kind, &[], &mut worn)?;
        let relief = self.relief(&meaning, &mut worn)?;
        let index = match Self::dress(coat, relief) {
            Some(dress) => self.builder.dressed(material, dress),
            None => self.builder.material(material),
        };
        self.worn.resize(index as usize + 1, Worn::default());
        self.worn[index as usize] = worn;
        let emission = match meaning.emission {
            Some(Emission::Radiance(radiance)) => rgb(radiance),
            _ => Rgb::ZERO,
        };
        Ok(Own { name: meaning.name.unwrap_or_default().into(), index, emission })
    }
}
