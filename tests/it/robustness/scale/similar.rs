//! Similarity transforms of scene descriptions.
//!
//! The code names every field with a unit of length. Matches are exhaustive, so the compiler
//! reports each field that is added to the scene language.

use caustica::format::description::{
    ApertureDescription, AreaLightStrength, CameraDescription, DensityDescription, DielectricAbsorption,
    DielectricDescription, DirectionOrTarget, DirectionalLightDescription, DirectionalLightStrength,
    DiscLightDescription, EmissionDescription, EnvironmentRadiance, FocusDescription, GoniometricLightDescription,
    GroupItem, LensDescription, LightDescription, MaterialDescription, MaterialKindDescription, MediumCoefficients,
    MediumDescription, NormalPerturbationDescription, ObjectDescription, PointLightDescription, PointLightStrength,
    PrincipledDescription, ProjectionDescription, ProjectorLightDescription, RectangleLightDescription,
    SceneDescription, Span, Spanned, SphereLightDescription, SpotLightDescription, TextureKindDescription,
    TransformStep, TransformedBoxDescription,
};
use glam::{DAffine3, DMat4, DVec3};

/// The map x ↦ shift + scale · turn(x).
#[derive(Clone, Copy, Debug)]
pub struct Similarity {
    /// Scale factor, above 0.
    pub scale: f64,
    /// Axis and angle \[degrees] of the rotation, which is right-handed.
    pub turn: (DVec3, f64),
    pub shift: DVec3,
}

impl Similarity {
    pub const NONE: Self = Self { scale: 1.0, turn: (DVec3::Y, 0.0), shift: DVec3::ZERO };

    pub fn scaled(scale: f64) -> Self {
        Self { scale, ..Self::NONE }
    }

    /// Returns the description transformed by this map. Its image has equal radiance.
    pub fn of(&self, mut d: SceneDescription) -> SceneDescription {
        let SceneDescription { camera, background: _, ambient_medium: _, lights, textures, media, materials, root } =
            &mut d;
        self.camera(&mut camera.value);
        lights.iter_mut().for_each(|light| self.light(&mut light.value));
        // Textures are in the object space of their objects, which the transform of the root group
        // covers.
        for texture in textures {
            match &texture.kind {
                TextureKindDescription::Image { .. }
                | TextureKindDescription::Checker { .. }
                | TextureKindDescription::Solid { .. } => {}
            }
        }
        media.iter_mut().for_each(|medium| self.medium(&mut medium.value));
        materials.iter_mut().for_each(|material| self.material(&mut material.value));
        let inner = Spanned::new(ObjectDescription::Group(std::mem::take(root)), Span::default());
        let outer = ObjectDescription::Transform { steps: self.steps(), object: Box::new(inner) };
        root.items.push(GroupItem::Object(Spanned::new(outer, Span::default())));
        d
    }

    fn steps(&self) -> Vec<TransformStep> {
        let mut steps = vec![TransformStep::Translate(self.shift)];
        if self.turns() {
            steps.push(TransformStep::Rotate { axis: self.turn.0, angle: self.turn.1 });
        }
        steps.push(TransformStep::UniformScale(self.scale));
        steps
    }

    fn turns(&self) -> bool {
        self.turn.1 != 0.0
    }

    fn matrix(&self) -> DAffine3 {
        TransformStep::composed_matrix(&self.steps())
    }

    /// Returns the image of a point.
    pub fn place(&self, p: DVec3) -> DVec3 {
        self.matrix().transform_point3(p)
    }

    fn point(&self, p: &mut DVec3) {
        *p = self.place(*p);
    }

    fn vector(&self, v: &mut DVec3) {
        *v = self.matrix().transform_vector3(*v);
    }

    fn length(&self, x: &mut f64) {
        *x *= self.scale;
    }

    fn per_length(&self, x: &mut DVec3) {
        *x /= self.scale;
    }

    fn area(&self, x: &mut DVec3) {
        *x *= self.scale * self.scale;
    }

    fn aim(&self, aim: &mut DirectionOrTarget) {
        match aim {
            DirectionOrTarget::Direction(direction) => self.vector(direction),
            DirectionOrTarget::Target(point) => self.point(point),
        }
    }

    /// Transforms the steps of a motion, for which the object's position is the origin.
    fn motion(&self, steps: &mut [TransformStep]) {
        for map in steps {
            *map = match *map {
                TransformStep::Translate(mut by) => {
                    self.vector(&mut by);
                    TransformStep::Translate(by)
                }
                TransformStep::UniformScale(by) => TransformStep::UniformScale(by),
                TransformStep::Scale(by) if !self.turns() => TransformStep::Scale(by),
                TransformStep::Scale(_) => panic!("no scene turns what is stretched unevenly while it moves"),
                TransformStep::RotateX(angle) => self.turned(DVec3::X, angle),
                TransformStep::RotateY(angle) => self.turned(DVec3::Y, angle),
                TransformStep::RotateZ(angle) => self.turned(DVec3::Z, angle),
                TransformStep::Rotate { axis, angle } => self.turned(axis, angle),
                TransformStep::Matrix(_) => panic!("no matrix moves"),
            };
        }
    }

    fn turned(&self, mut axis: DVec3, angle: f64) -> TransformStep {
        self.vector(&mut axis);
        TransformStep::Rotate { axis, angle }
    }

    fn camera(&self, camera: &mut CameraDescription) {
        let CameraDescription { center, aim, up, projection, width: _, height: _, motion } = camera;
        self.aim(aim);
        self.point(center);
        self.vector(up);
        match projection {
            ProjectionDescription::Perspective { vertical_fov_degrees: _, lens } => {
                lens.iter_mut().for_each(|lens| self.lens(lens))
            }
            ProjectionDescription::Orthographic { view_height: size } => self.length(size),
            ProjectionDescription::Panorama => {}
        }
        self.motion(motion);
    }

    fn lens(&self, lens: &mut LensDescription) {
        let LensDescription { aperture, focus, blades: _ } = lens;
        match aperture {
            ApertureDescription::Radius(radius) => self.length(radius),
            ApertureDescription::FNumber { number: _, sensor_height: sensor } => self.length(sensor),
        }
        match focus {
            FocusDescription::Distance(distance) => self.length(distance),
            FocusDescription::Point(point) => self.point(point),
        }
    }

    fn light(&self, light: &mut LightDescription) {
        match light {
            LightDescription::Point(PointLightDescription { position, strength }) => {
                self.point(position);
                self.intensity(strength);
            }
            LightDescription::Directional(DirectionalLightDescription { direction, strength }) => {
                self.vector(direction);
                match strength {
                    DirectionalLightStrength::Mit6837Color(_) | DirectionalLightStrength::Irradiance(_) => {}
                }
            }
            LightDescription::Spot(SpotLightDescription {
                position,
                aim,
                full_cone_angle_degrees: _,
                penumbra_degrees: _,
                strength,
            }) => {
                self.aim(aim);
                self.point(position);
                self.intensity(strength);
            }
            LightDescription::Projector(ProjectorLightDescription {
                pose,
                vertical_fov_degrees: _,
                path: _,
                strength,
            })
            | LightDescription::Goniometric(GoniometricLightDescription { pose, distribution: _, strength }) => {
                self.aim(&mut pose.aim);
                self.point(&mut pose.position);
                if let Some(up) = &mut pose.up {
                    self.vector(up);
                }
                self.intensity(strength);
            }
            LightDescription::Sphere(SphereLightDescription { center, radius, strength }) => {
                self.point(center);
                self.length(radius);
                self.radiance(strength);
            }
            LightDescription::Disc(DiscLightDescription { center, normal, radius, strength }) => {
                self.point(center);
                self.vector(normal);
                self.length(radius);
                self.radiance(strength);
            }
            LightDescription::Rectangle(RectangleLightDescription { corner, edge0, edge1, strength }) => {
                self.point(corner);
                self.vector(edge0);
                self.vector(edge1);
                self.radiance(strength);
            }
            LightDescription::Moving { steps, light } => {
                self.motion(steps);
                self.light(&mut light.value);
            }
            LightDescription::Environment(EnvironmentRadiance::Constant(_)) => {}
            LightDescription::Environment(EnvironmentRadiance::Picture { path: _, scale: _, rotate }) => {
                assert!(!self.turns() || self.turn.0 == DVec3::Y, "a picture of the sky turns about y alone");
                *rotate += self.turn.1;
            }
        }
    }

    /// Scales intensity or power of a light with the square of the scale, since irradiance is
    /// intensity over squared length.
    fn intensity(&self, strength: &mut PointLightStrength) {
        match strength {
            // This strength is the radiance of a white surface at the scene's center. It does not
            // depend on scale.
            PointLightStrength::Mit6837Color(_) => {}
            PointLightStrength::Intensity(watts) | PointLightStrength::Power(watts) => self.area(watts),
        }
    }

    fn radiance(&self, strength: &mut AreaLightStrength) {
        match strength {
            AreaLightStrength::Radiance(_) => {}
            AreaLightStrength::Power(watts) => self.area(watts),
        }
    }

    fn medium(&self, medium: &mut MediumDescription) {
        let MediumDescription { name: _, coefficients, emission, phase: _, density } = medium;
        match coefficients {
            MediumCoefficients::AbsorptionScattering { absorption, scattering } => {
                self.per_length(absorption);
                self.per_length(scattering);
            }
            MediumCoefficients::ExtinctionAlbedo { extinction, albedo: _ } => self.per_length(extinction),
        }
        self.per_length(emission);
        match density {
            DensityDescription::Homogeneous => {}
            DensityDescription::Grid { path: _, scale: _, extent } => self.extent(extent),
            DensityDescription::Cloud {
                cover: _,
                softness: _,
                octaves: _,
                frequency: _,
                seed: _,
                resolution: _,
                extent,
            } => self.extent(extent),
        }
    }

    /// Replaces the steps of a box's transform by one matrix that includes this map.
    ///
    /// A matrix appended to the steps would be applied after the steps before it.
    fn extent(&self, extent: &mut TransformedBoxDescription) {
        let TransformedBoxDescription { min: _, max: _, steps } = extent;
        *steps = vec![TransformStep::Matrix(DMat4::from(self.matrix() * TransformStep::composed_matrix(steps)))];
    }

    fn material(&self, material: &mut MaterialDescription) {
        let MaterialDescription { name: _, kind, emission, normal_perturbation, medium: _ } = material;
        match kind {
            MaterialKindDescription::Dielectric(DielectricDescription { absorption: attenuation, .. })
            | MaterialKindDescription::Principled(PrincipledDescription { absorption: attenuation, .. }) => {
                match attenuation {
                    DielectricAbsorption::None => {}
                    DielectricAbsorption::Coefficient(sigma) => self.per_length(sigma),
                    DielectricAbsorption::Tint { color: _, distance } => self.length(distance),
                }
            }
            MaterialKindDescription::Phong(_)
            | MaterialKindDescription::Diffuse(_)
            | MaterialKindDescription::Mirror(_)
            | MaterialKindDescription::NullInterface(_)
            | MaterialKindDescription::Conductor(_)
            | MaterialKindDescription::Thin(_)
            | MaterialKindDescription::CoatedDiffuse(_)
            | MaterialKindDescription::DiffuseTransmission(_)
            | MaterialKindDescription::Mix(_) => {}
        }
        match emission {
            None | Some(EmissionDescription::Constant(_) | EmissionDescription::Texture { .. }) => {}
        }
        match normal_perturbation {
            Some(NormalPerturbationDescription::Bump { texture: _, height }) => self.length(height),
            None | Some(NormalPerturbationDescription::NormalMap(_)) => {}
        }
    }
}
