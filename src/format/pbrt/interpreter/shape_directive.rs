//! Executes the directive `Shape`: adds a shape with its material and emission to the scene.

use super::Interpreter;
use crate::format::description::ShapeDescription;
use crate::format::pbrt::content::PbrtSceneContent;
use crate::format::pbrt::files::{PbrtSourceLocation, ReadResult};
use crate::format::pbrt::graphics_state::MovingTransform;
use crate::format::pbrt::lights::PbrtShapeEmission;
use crate::format::pbrt::materials::{PbrtImportedMaterial, PbrtMaterialUse};
use crate::format::pbrt::objects::{MEMORY_PER_OBJECT, PbrtPlacement};
use crate::format::pbrt::parameters::{Parameter, Parameters};
use crate::format::pbrt::shape_properties::{
    back_side_shape, has_texcoords_of_pbrt, is_sheet, lamp_count, lamps_have_equal_areas, textured_sphere_rotation,
    world_area,
};
use crate::format::pbrt::shapes::read_shape;
use crate::format::pbrt::textures::PbrtTexture;
use glam::DVec3;
use std::rc::Rc;

impl Interpreter<'_> {
    /// Adds a shape of type `kind` to the scene, or to the object definition that is open.
    pub(super) fn add_shape(&mut self, kind: &str, parameters: &Parameters) -> ReadResult<()> {
        let place = &parameters.place;
        self.files.reserve_memory(MEMORY_PER_OBJECT)?;
        let name = format!("shape{}", self.shape_count);
        self.shape_count += 1;
        let orientation = (self.state.is_reversed, false);
        let shape = read_shape((kind, &name), parameters, orientation, &mut self.content, self.files)?;
        let Some(mut shape) = shape else { return Ok(()) };
        let inside = Rc::clone(&self.state.medium_interface[0]);
        let separates_media = inside != self.state.medium_interface[1];
        let medium = (!inside.is_empty() && separates_media && self.media.contains(&inside)).then_some(&*inside);
        let emission = self.shape_emission(place)?;
        let alpha = parameters.find("alpha");
        let mut transform = self.transform_over_shutter();
        let PbrtSceneContent { meshes, textures, materials, notes, .. } = &mut self.content;
        let shape_properties = PbrtMaterialUse { medium, alpha, place };
        let PbrtImportedMaterial { name: material, needs_texcoords } =
            materials.imported_material(&self.state.material, &shape_properties, textures, self.files, notes)?;
        if needs_texcoords && !has_texcoords_of_pbrt(&shape, meshes) {
            if let ShapeDescription::Sphere(_) = shape {
                transform = MovingTransform(transform.0.map(|map| map * textured_sphere_rotation()));
            } else {
                let orientation = (self.state.is_reversed, true);
                let textured = read_shape((kind, &name), parameters, orientation, &mut self.content, self.files)?;
                shape = textured.unwrap_or(shape);
            }
        }
        let PbrtSceneContent { meshes, materials, notes, .. } = &mut self.content;
        if separates_media && !materials.can_contain_medium(&material) && is_sheet(&shape, meshes) {
            // pbrt lets light that leaves the back of a sheet travel through the inner medium.
            let message = "sheets do not separate media: the medium around is on both sides";
            notes.add_unsupported(message, place.position_text());
        }
        let radiance = match emission {
            Some(emission) => Some(self.emitted_radiance(&emission, (kind, parameters), &shape, transform)?),
            None => None,
        };
        let PbrtSceneContent { meshes, notes, .. } = &mut self.content;
        let mut shapes = vec![shape];
        if emission.is_some_and(|emission| emission.is_two_sided) {
            shapes.extend(back_side_shape(&shapes[0], &name, meshes, self.files)?);
        }
        self.lights.has_emissive_surfaces |= radiance.is_some_and(|radiance| radiance != DVec3::ZERO);
        let placement = PbrtPlacement { mirror: self.mirror, transform, place };
        self.objects.add_shapes(material, shapes, radiance, &placement, notes);
        Ok(())
    }

    /// Returns the emission of the current `AreaLightSource`; `None` if shapes emit nothing.
    ///
    /// Shapes inside an object definition emit nothing, and a message tells the user.
    fn shape_emission(&mut self, place: &PbrtSourceLocation) -> ReadResult<Option<PbrtShapeEmission>> {
        let Some(light) = &self.state.area_light else { return Ok(None) };
        if self.objects.has_open_definition() {
            let message = "shapes of object instances emit no light";
            self.content.notes.add_unsupported(message, place.position_text());
            return Ok(None);
        }
        PbrtShapeEmission::from_parameters(&light.parameters, self.files, &mut self.content).map(Some)
    }

    /// Returns the emitted radiance of a shape of type `kind` \[W/(m² sr)].
    ///
    /// The file states this radiance, or the power of the shape, which is then divided by its area.
    /// In pbrt-v4, the opacity of the shape scales the result.
    fn emitted_radiance(
        &mut self,
        emission: &PbrtShapeEmission,
        (kind, parameters): (&str, &Parameters),
        shape: &ShapeDescription,
        transform: MovingTransform,
    ) -> ReadResult<DVec3> {
        let place = &parameters.place;
        let to_world = transform.0[0];
        let PbrtSceneContent { meshes, notes, .. } = &mut self.content;
        // In pbrt, each triangle of a mesh is a lamp of its own, and each has the whole `power`.
        let count = lamp_count((kind, parameters), shape, meshes);
        if emission.is_flux() && count > 1 && !lamps_have_equal_areas(kind, shape, meshes, to_world) {
            let message = "`power` of lamps that are meshes is even over their area: pbrt divides it by triangle";
            notes.add_unsupported(message, place.position_text());
        }
        let radiance = emission.radiance(|| world_area(shape, meshes, to_world) / count as f64);
        let Some(alpha) = parameters.find("alpha").filter(|_| !self.content.is_v3) else { return Ok(radiance) };
        Ok(radiance * self.opacity_factor(alpha, place)?)
    }

    /// Returns the mean of the opacity `alpha` of an emitting shape. The radiance of the shape is
    /// multiplied by this mean.
    ///
    /// Returns 1 for a constant opacity of 0, because pbrt then hides the shape but keeps its full
    /// radiance.
    fn opacity_factor(&mut self, alpha: &Parameter, place: &PbrtSourceLocation) -> ReadResult<f64> {
        let PbrtSceneContent { textures, notes, .. } = &mut self.content;
        let value = textures.parameter_value(alpha, false, place, self.files)?;
        let share = (value.mean().element_sum() / 3.0).clamp(0.0, 1.0);
        match value {
            PbrtTexture::Constant(_) if share == 0.0 => {
                notes.add_unsupported("lamps with opacity 0 are visible", place.position_text());
                Ok(1.0)
            }
            PbrtTexture::Constant(_) => Ok(share),
            PbrtTexture::Picture { .. } | PbrtTexture::Checker { .. } | PbrtTexture::Solid { .. } => {
                notes.add_unsupported("lamps with a texture of opacity emit evenly", place.position_text());
                Ok(share)
            }
        }
    }
}
