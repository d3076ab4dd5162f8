//! Converts one material of a glTF file to a material of the scene language.

use super::{GltfImportedMaterial, GltfMaterials};
use crate::bsdf::MAX_COAT_INDEX;
use crate::format::description::{
    CoatedDiffuseDescription, ConductorDescription, DielectricAbsorption, DielectricDescription, DiffuseDescription,
    EmissionDescription, MaterialDescription, MaterialKindDescription, MetalDescription, NormalPerturbationDescription,
    PhongDescription, RefractiveIndexDescription, TexturedValue, ThinDielectricDescription,
};
use crate::format::gltf::context::{FileContext, ReadResult};
use crate::format::gltf::document::IGNORED_MATERIAL_EXTENSIONS;
use crate::format::gltf::textures::{GltfConvertedTexture, GltfTextureUse, TextureReference};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_materials::mix_of;
use glam::{DVec3, DVec4};
use gltf::material::AlphaMode;

/// Least transmittance of glass, by color channel; smaller values are raised to it.
///
/// A transmittance of 0 would need an infinite absorption coefficient.
const MIN_TRANSMITTANCE: f64 = 1e-6;

/// Least attenuation distance of glass \[length]; smaller distances are raised to it.
///
/// Together with [`MIN_TRANSMITTANCE`], it keeps absorption coefficients below 10¹² per length.
const MIN_ATTENUATION_DISTANCE: f64 = 1e-10;

/// Least Abbe number of glass with dispersion. Glass with a smaller Abbe number gets a refractive
/// index that is constant over wavelength.
///
/// With this Abbe number and the index [`MAX_DISPERSIVE_INDEX`], the refractive index goes from 2.5
/// at 720 nm to 5.1 at 380 nm.
const MIN_ABBE_NUMBER: f64 = 2.0;

/// Greatest refractive index of glass with dispersion. Glass with a greater index is imported
/// without dispersion: its index is equal at all wavelengths.
const MAX_DISPERSIVE_INDEX: f64 = 3.0;

/// Parameters of glTF's metallic-roughness model from which its parts are made: metal, opaque
/// dielectric and glass. Metalness and transmission, which blend these parts, are not included.
pub(super) struct MetallicRoughnessSurface<'a> {
    /// Base color in \[0, 1], which multiplies `base_texture`.
    pub base_color: DVec3,
    /// Texture of the base color; `None` stands for white.
    pub base_texture: Option<TextureReference<'a>>,
    /// Reflectance of the dielectric part at normal incidence, by color channel.
    pub f0: DVec3,
    /// GGX α as a constant or a texture, and the mean of α over all pixels.
    pub ggx_alpha_and_mean: (TexturedValue<f64>, f64),
}

/// Converter of one glTF material, with the tables that receive its materials and messages.
pub(super) struct GltfMaterialConverter<'m, 'a> {
    /// Materials of the imported scene so far. The converter adds its results here.
    pub materials: &'m mut GltfMaterials<'a>,
    /// Messages about content that is ignored or approximated.
    pub notes: &'m mut ImportNotes,
    /// The glTF file that is imported, for error messages.
    pub context: &'m FileContext<'a>,
    /// Name of the material in the imported scene, also for messages.
    pub name: String,
    /// Index of the texture coordinates that the material's first texture uses (`TEXCOORD_0`, …);
    /// `None` as long as no texture has been converted.
    pub texcoord_set: Option<u32>,
    /// Normal map of the material; `None` without one.
    pub normal: Option<NormalPerturbationDescription>,
}

impl GltfMaterialConverter<'_, '_> {
    /// Converts `material`, adds the result to the imported scene, and returns its name and
    /// properties.
    ///
    /// `vertex_color` multiplies the base color and alpha.
    pub(super) fn convert_material(
        &mut self,
        material: &gltf::Material<'_>,
        vertex_color: DVec4,
    ) -> ReadResult<GltfImportedMaterial> {
        for (extension, message) in IGNORED_MATERIAL_EXTENSIONS {
            if material.extension_value(extension).is_some() {
                self.add_note(message);
            }
        }
        let pbr = material.pbr_metallic_roughness();
        let glossy = material.pbr_specular_glossiness();
        let (factor, texture) = match &glossy {
            Some(glossy) => (glossy.diffuse_factor(), glossy.diffuse_texture()),
            None => (pbr.base_color_factor(), pbr.base_color_texture()),
        };
        let base_texture = self.texture_reference(texture.as_ref());
        let factor = DVec4::from(factor.map(clamped_to_unit)) * vertex_color;
        let alpha = self.opacity(material, factor.w, base_texture.as_ref())?;
        let emission = self.emission(material, factor.truncate(), base_texture.as_ref())?;
        let emission = emission.map(|emission| self.emission_times_alpha(emission, &alpha));
        let emits = emission.is_some();
        let kind = if material.unlit() {
            self.add_note("unlit surfaces emit their base color, and reflect nothing");
            MaterialKindDescription::Diffuse(DiffuseDescription { reflectance: DVec3::ZERO.into() })
        } else {
            self.surface_description(material, factor.truncate(), base_texture)?
        };
        let kind = match &alpha {
            TexturedValue::Constant(alpha) if *alpha == 1.0 => kind,
            _ => {
                let (clear, solid) =
                    (self.materials.list.transparent_material_name(), self.add_mix_component("solid", kind));
                mix_of(clear, solid, alpha.clone())
            }
        };
        let normal = if kind.mix_material_names().is_none() { self.normal.take() } else { None };
        self.materials.list.push(MaterialDescription {
            name: Some(self.name.clone()),
            kind,
            emission,
            normal_perturbation: normal,
            medium: None,
        });
        let is_invisible = alpha == TexturedValue::Constant(0.0);
        Ok(GltfImportedMaterial { name: self.name.clone(), texcoord_set: self.texcoord_set, is_invisible, emits })
    }

    /// Converts the reflection and transmission of a material. The caller adds opacity and
    /// emission.
    ///
    /// The base color is `base` times `base_texture`. Also stores the normal map in `self.normal`.
    fn surface_description<'t>(
        &mut self,
        material: &gltf::Material<'t>,
        base: DVec3,
        base_texture: Option<TextureReference<'t>>,
    ) -> ReadResult<MaterialKindDescription> {
        let pbr = material.pbr_metallic_roughness();
        self.normal = self.normal_map(material)?;
        let (metallic, alpha) = match material.pbr_specular_glossiness() {
            Some(glossy) => {
                if glossy.specular_glossiness_texture().is_some() {
                    self.add_note("textures of specular color and glossiness are ignored");
                }
                let roughness = 1.0 - clamped_to_unit(glossy.glossiness_factor());
                (TexturedValue::Constant(0.0), (TexturedValue::Constant(roughness * roughness), roughness * roughness))
            }
            None => {
                let texture = self.texture_reference(pbr.metallic_roughness_texture().as_ref());
                let roughness = clamped_to_unit(pbr.roughness_factor());
                let metallic = self.textured_scalar_and_mean(
                    texture.as_ref(),
                    GltfTextureUse::Channel(2, clamped_to_unit(pbr.metallic_factor())),
                )?;
                let alpha = self.textured_scalar_and_mean(texture.as_ref(), GltfTextureUse::GgxAlpha(roughness))?;
                (metallic.0, alpha)
            }
        };
        let index = self.refractive_index(material);
        let surface = MetallicRoughnessSurface {
            base_color: base,
            base_texture,
            f0: self.dielectric_normal_reflectance(material, index),
            ggx_alpha_and_mean: alpha,
        };
        if let Some(coat) = self.clear_coat(material)? {
            return self.clear_coated_description(&surface, metallic, coat);
        }
        if metallic == TexturedValue::Constant(1.0) {
            return self.metal_description(&surface);
        }
        let dielectric = self.dielectric_description(material, &surface, index)?;
        if metallic == TexturedValue::Constant(0.0) {
            return Ok(dielectric);
        }
        let metal = self.metal_description(&surface)?;
        let (first, second) =
            (self.add_mix_component("dielectric", dielectric), self.add_mix_component("metal", metal));
        Ok(mix_of(first, second, metallic))
    }

    /// Converts the dielectric part of the metallic-roughness model, with refractive index `index`.
    ///
    /// The extension KHR_materials_transmission decides the result: an opaque material, glass, or a
    /// mix of both.
    fn dielectric_description(
        &mut self,
        material: &gltf::Material<'_>,
        surface: &MetallicRoughnessSurface<'_>,
        index: f64,
    ) -> ReadResult<MaterialKindDescription> {
        let Some(transmission) = material.transmission() else {
            return self.sheet_or_opaque_description(material, surface);
        };
        let factor = clamped_to_unit(transmission.transmission_factor());
        let texture = self.texture_reference(transmission.transmission_texture().as_ref());
        let (amount, _) = self.textured_scalar_and_mean(texture.as_ref(), GltfTextureUse::Channel(0, factor))?;
        if amount == TexturedValue::Constant(0.0) {
            return self.sheet_or_opaque_description(material, surface);
        }
        let glass = self.glass_description(material, surface, index)?;
        if amount == TexturedValue::Constant(1.0) {
            return Ok(glass);
        }
        let opaque_dielectric = self.sheet_or_opaque_description(material, surface)?;
        let (first, second) =
            (self.add_mix_component("opaque", opaque_dielectric), self.add_mix_component("glass", glass));
        Ok(mix_of(first, second, amount))
    }

    /// Converts the opaque dielectric part of the metallic-roughness model.
    ///
    /// The reflectance at normal incidence decides the result:
    ///
    /// - 0: a diffuse surface.
    /// - Gray, and at most the reflectance of a dielectric with index [`MAX_COAT_INDEX`]: a diffuse
    ///   base under a coat.
    /// - Otherwise: a diffuse surface with a Phong lobe for the gloss.
    pub(super) fn opaque_dielectric_description(
        &mut self,
        surface: &MetallicRoughnessSurface<'_>,
    ) -> ReadResult<MaterialKindDescription> {
        let MetallicRoughnessSurface { base_color: base, base_texture, f0, ggx_alpha_and_mean: alpha } = surface;
        if *f0 == DVec3::ZERO {
            let reflectance = self.textured_color(base_texture.as_ref(), *base)?;
            return Ok(MaterialKindDescription::Diffuse(DiffuseDescription { reflectance }));
        }
        if let Some(eta) = coat_refractive_index(*f0) {
            return Ok(MaterialKindDescription::CoatedDiffuse(CoatedDiffuseDescription {
                reflectance: self.textured_color(base_texture.as_ref(), *base)?,
                eta,
                roughness: alpha.0.clone(),
                is_nonlinear: false,
            }));
        }
        let diffuse_share = 1.0 - f0.max_element();
        let diffuse = self.textured_color(base_texture.as_ref(), *base * diffuse_share)?;
        self.add_note(
            "strong or colored gloss of non-metals is a Phong lobe, which does not grow towards grazing angles",
        );
        Ok(MaterialKindDescription::Phong(PhongDescription::in_place_of_ggx(diffuse, *f0, alpha.1)))
    }

    /// Converts the metal part of the metallic-roughness model.
    ///
    /// The reflectance of the metal at normal incidence is the base color.
    fn metal_description(&mut self, surface: &MetallicRoughnessSurface<'_>) -> ReadResult<MaterialKindDescription> {
        let MetallicRoughnessSurface { base_color: base, base_texture, ggx_alpha_and_mean: alpha, .. } = surface;
        let metal = match self.textured_color(base_texture.as_ref(), *base)? {
            TexturedValue::Constant(color) => MetalDescription::with_clamped_reflectance(color),
            texture @ TexturedValue::Texture(_) => MetalDescription::Reflectance(texture),
        };
        Ok(MaterialKindDescription::Conductor(ConductorDescription {
            metal,
            roughness: alpha.0.clone(),
            has_multiple_scattering: true,
        }))
    }

    /// Converts a material that transmits light to glass with the refractive index `index`.
    ///
    /// With a volume of thickness above 0 (KHR_materials_volume), the result is a solid body. Else
    /// it is a thin pane.
    fn glass_description(
        &mut self,
        material: &gltf::Material<'_>,
        surface: &MetallicRoughnessSurface<'_>,
        index: f64,
    ) -> ReadResult<MaterialKindDescription> {
        let MetallicRoughnessSurface { base_color: base, base_texture, ggx_alpha_and_mean: alpha, .. } = surface;
        let Some(volume) = material.volume().filter(|volume| volume.thickness_factor() > 0.0) else {
            if alpha.1 > 0.0 {
                self.add_note("panes (transmission without volume) are smooth");
            }
            let transmittance = match self.textured_color(base_texture.as_ref(), *base)? {
                TexturedValue::Constant(color) => color.max(DVec3::splat(MIN_TRANSMITTANCE)).into(),
                texture @ TexturedValue::Texture(_) => texture,
            };
            return Ok(MaterialKindDescription::Thin(ThinDielectricDescription { eta: index, transmittance }));
        };
        if base_texture.is_some() || *base != DVec3::ONE {
            self.add_note("the base color of bodies of glass is ignored: their color is that of their attenuation");
        }
        let distance = f64::from(volume.attenuation_distance());
        let distance = if distance > 0.0 { distance.max(MIN_ATTENUATION_DISTANCE) } else { distance };
        let color = DVec3::from(volume.attenuation_color().map(clamped_to_unit)).max(DVec3::splat(MIN_TRANSMITTANCE));
        let is_clear = !(distance > 0.0 && distance.is_finite()) || color == DVec3::ONE;
        let attenuation =
            if is_clear { DielectricAbsorption::None } else { DielectricAbsorption::Tint { color, distance } };
        let dispersion = material.extension_value("KHR_materials_dispersion");
        let dispersion = dispersion.and_then(|value| value.get("dispersion")?.as_f64()).filter(|d| *d > 0.0);
        let refraction = match dispersion.map(|dispersion| 20.0 / dispersion) {
            Some(abbe) if abbe >= MIN_ABBE_NUMBER && index <= MAX_DISPERSIVE_INDEX => {
                RefractiveIndexDescription::Abbe { index, abbe }
            }
            Some(_) => {
                self.add_note("dispersion that is larger than that of any glass is ignored");
                index.into()
            }
            None => index.into(),
        };
        let (roughness, multiple_scattering) = (alpha.0.clone(), true);
        Ok(MaterialKindDescription::Dielectric(DielectricDescription {
            refraction,
            absorption: attenuation,
            roughness,
            has_multiple_scattering: multiple_scattering,
            priority: 0,
        }))
    }

    /// Returns the index of refraction; 1.5 without the extension KHR_materials_ior, or if the
    /// index in the file is outside \[1, 1000].
    fn refractive_index(&mut self, material: &gltf::Material<'_>) -> f64 {
        let index = material.ior().map_or(1.5, f64::from);
        if (1.0..=1e3).contains(&index) {
            return index;
        }
        if index != 0.0 {
            self.add_note("an index of refraction below 1 or above 1000 is taken as 1.5");
        }
        1.5
    }

    /// Returns the reflectance of the material's dielectric part at normal incidence, in \[0, 1].
    ///
    /// The reflectance follows from the refractive `index` and the extension
    /// KHR_materials_specular. An index of 0 in the file stands for total reflection. For a
    /// specular-glossiness material, the reflectance is its specular color.
    fn dielectric_normal_reflectance(&mut self, material: &gltf::Material<'_>, index: f64) -> DVec3 {
        if let Some(glossy) = material.pbr_specular_glossiness() {
            return glossy.specular_factor().map(clamped_to_unit).into();
        }
        let root = if material.ior() == Some(0.0) { 1.0 } else { (index - 1.0) / (index + 1.0) };
        let Some(specular) = material.specular() else { return DVec3::splat(root * root) };
        if specular.specular_texture().is_some() || specular.specular_color_texture().is_some() {
            self.add_note("textures of specular strength and color are ignored");
        }
        let color = specular.specular_color_factor().map(|c| f64::from(c).clamp(0.0, 1e6));
        (DVec3::from(color) * root * root).min(DVec3::ONE) * clamped_to_unit(specular.specular_factor())
    }

    /// Returns the opacity of a material in \[0, 1], by its alpha mode, as a constant or a texture.
    ///
    /// Alpha is `factor` times the alpha channel of `texture`. The opacity is 1 in mode `OPAQUE`
    /// and alpha in mode `BLEND`. In mode `MASK`, it is 1 where alpha reaches the cutoff, else 0.
    fn opacity(
        &mut self,
        material: &gltf::Material<'_>,
        factor: f64,
        texture: Option<&TextureReference<'_>>,
    ) -> ReadResult<TexturedValue<f64>> {
        let texture_use = match material.alpha_mode() {
            AlphaMode::Opaque => return Ok(TexturedValue::Constant(1.0)),
            AlphaMode::Blend => GltfTextureUse::Channel(3, factor),
            AlphaMode::Mask => GltfTextureUse::AlphaMask(factor, f64::from(material.alpha_cutoff().unwrap_or(0.5))),
        };
        Ok(self.textured_scalar_and_mean(texture, texture_use)?.0)
    }

    /// Returns the emitted radiance, constant or by a texture; `None` if the surface emits nothing.
    ///
    /// An unlit material emits its base color `base` times `base_texture`.
    fn emission(
        &mut self,
        material: &gltf::Material<'_>,
        base: DVec3,
        base_texture: Option<&TextureReference<'_>>,
    ) -> ReadResult<Option<EmissionDescription>> {
        let strength = f64::from(material.emissive_strength().unwrap_or(1.0)).max(0.0);
        if !strength.is_finite() {
            return Err(self.context.error(&self.name, "its emissive strength is not finite"));
        }
        let emissive_texture = self.texture_reference(material.emissive_texture().as_ref());
        let (factor, texture, scale) = if material.unlit() {
            (base, base_texture, 1.0)
        } else {
            (material.emissive_factor().map(clamped_to_unit).into(), emissive_texture.as_ref(), strength)
        };
        if factor * scale == DVec3::ZERO {
            return Ok(None);
        }
        if material.double_sided() {
            self.add_note("surfaces emit light from their front only");
        }
        Ok(match self.textured_color(texture, factor)? {
            TexturedValue::Constant(color) if color == DVec3::ZERO => None,
            TexturedValue::Constant(color) => Some(EmissionDescription::Constant(color * scale)),
            TexturedValue::Texture(name) => Some(EmissionDescription::Texture { name, scale }),
        })
    }

    /// Returns `emission` times the opacity `alpha`, because only the opaque fraction of a surface
    /// emits.
    ///
    /// If `alpha` is a texture, returns `emission` unchanged and adds a note.
    fn emission_times_alpha(
        &mut self,
        emission: EmissionDescription,
        alpha: &TexturedValue<f64>,
    ) -> EmissionDescription {
        let alpha = match alpha {
            TexturedValue::Constant(alpha) => *alpha,
            TexturedValue::Texture(_) => {
                self.add_note("surfaces with a texture of alpha emit light from their transparent points too");
                1.0
            }
        };
        match emission {
            EmissionDescription::Constant(radiance) => EmissionDescription::Constant(radiance * alpha),
            EmissionDescription::Texture { name, scale } => EmissionDescription::Texture { name, scale: scale * alpha },
        }
    }

    /// Converts the normal map of a material; `None` without one, or if all its pixels are equal.
    fn normal_map(&mut self, material: &gltf::Material<'_>) -> ReadResult<Option<NormalPerturbationDescription>> {
        let Some(normal) = material.normal_texture() else { return Ok(None) };
        let reference = self.with_valid_transform(TextureReference::from_normal_texture(&normal));
        let scale = f64::from(normal.scale());
        let values = self
            .convert_texture(reference.as_ref(), GltfTextureUse::Normal(if scale.is_finite() { scale } else { 1.0 }))?;
        Ok(match values {
            Some(GltfConvertedTexture::Texture(name, _)) => Some(NormalPerturbationDescription::NormalMap(name)),
            Some(GltfConvertedTexture::Constant(_)) | None => None,
        })
    }

    /// Returns the texture that `info` refers to, with its texture coordinates.
    ///
    /// `None` if `info` is `None`. A texture whose transform is not invertible also gives `None`,
    /// and a message tells the user.
    pub(super) fn texture_reference<'t>(
        &mut self,
        info: Option<&gltf::texture::Info<'t>>,
    ) -> Option<TextureReference<'t>> {
        self.with_valid_transform(TextureReference::from_info(info?))
    }

    /// Returns `reference`. Returns `None` if its texture transform is not invertible, and a
    /// message tells the user.
    pub(super) fn with_valid_transform<'t>(&mut self, reference: TextureReference<'t>) -> Option<TextureReference<'t>> {
        if reference.has_valid_transform() {
            return Some(reference);
        }
        self.add_note("textures that are scaled to nothing are left out");
        None
    }

    /// Returns the color of a surface: `factor` times the texture, if there is one.
    pub(super) fn textured_color(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        factor: DVec3,
    ) -> ReadResult<TexturedValue<DVec3>> {
        Ok(match self.convert_texture(texture, GltfTextureUse::Color(factor))? {
            Some(GltfConvertedTexture::Constant(color)) => TexturedValue::Constant(color),
            Some(GltfConvertedTexture::Texture(name, _)) => TexturedValue::Texture(name),
            None => TexturedValue::Constant(factor),
        })
    }

    /// Returns a number parameter in \[0, 1], as a constant or a texture, and its mean over all
    /// pixels.
    ///
    /// `texture_use` states the parameter: it selects the channel of `texture`, and holds the
    /// parameter's factor in the file. Without a texture, the channel counts as 1.
    pub(super) fn textured_scalar_and_mean(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        texture_use: GltfTextureUse,
    ) -> ReadResult<(TexturedValue<f64>, f64)> {
        let value_without_texture = match texture_use {
            GltfTextureUse::Channel(_, factor) => factor,
            GltfTextureUse::GgxAlpha(factor) => factor * factor,
            GltfTextureUse::AlphaMask(factor, cutoff) => f64::from(factor >= cutoff),
            GltfTextureUse::Color(_) | GltfTextureUse::Normal(_) => 1.0,
        };
        Ok(match self.convert_texture(texture, texture_use)? {
            Some(GltfConvertedTexture::Constant(value)) => (TexturedValue::Constant(value.x), value.x),
            Some(GltfConvertedTexture::Texture(name, mean)) => (TexturedValue::Texture(name), mean.x),
            None => (TexturedValue::Constant(value_without_texture), value_without_texture),
        })
    }

    /// Converts the pixels of `texture` for the parameter `texture_use`, such as a color. Returns
    /// `None` if there is no texture, or if its picture has an unsupported format.
    ///
    /// All textures of a material share one set of texture coordinates, the set of the first
    /// texture. A later texture with another set becomes a constant: the mean of its pixels.
    fn convert_texture(
        &mut self,
        texture: Option<&TextureReference<'_>>,
        texture_use: GltfTextureUse,
    ) -> ReadResult<Option<GltfConvertedTexture>> {
        let Some(texture) = texture else { return Ok(None) };
        let values = self.materials.textures.convert_texture(texture, texture_use, self.notes)?;
        if let Some(GltfConvertedTexture::Texture(..)) = &values {
            let texcoord_set = *self.texcoord_set.get_or_insert(texture.texcoord_set);
            if texcoord_set != texture.texcoord_set {
                self.add_note("textures with other texture coordinates than the first one become their mean");
                return Ok(values.map(|values| GltfConvertedTexture::Constant(values.mean())));
            }
        }
        Ok(values)
    }

    /// Adds one of the two materials of a mix to the imported scene, and returns its name.
    ///
    /// The name of the added material is the name of the mix, followed by `suffix`.
    pub(super) fn add_mix_component(&mut self, suffix: &str, kind: MaterialKindDescription) -> String {
        let name = self.materials.list.unique_name(&format!("{} {suffix}", self.name));
        let normal = if kind.mix_material_names().is_none() { self.normal.clone() } else { None };
        self.materials.list.push_surface(name.clone(), kind, normal);
        name
    }

    pub(super) fn add_note(&mut self, message: &str) {
        self.notes.add_unsupported(message, format!("material `{}`", self.name));
    }
}

/// Returns the refractive index whose Fresnel reflectance at normal incidence is `f0`.
///
/// `None` if the channels of `f0` differ, or if the index is above [`MAX_COAT_INDEX`].
pub(super) fn coat_refractive_index(f0: DVec3) -> Option<f64> {
    let root = f0.x.sqrt();
    let index = (1.0 + root) / (1.0 - root);
    (f0 == DVec3::splat(f0.x) && (1.0..=f64::from(MAX_COAT_INDEX)).contains(&index)).then_some(index)
}

/// Returns `factor` clamped to \[0, 1]; 0 for NaN.
pub(super) fn clamped_to_unit(factor: f32) -> f64 {
    if factor.is_nan() { 0.0 } else { f64::from(factor).clamp(0.0, 1.0) }
}
