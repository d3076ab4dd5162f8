//! What textures make of materials.

use super::Effect;
use super::material::phong;
use super::{Body, Hit, HitKind, Material, PhongAppearance, RayCone, Scattering, Scene, SurfaceInteraction};
use crate::bsdf::{Bsdf, Conductor, STORED_ALPHA, Thin};
use crate::color::Rgb;
use crate::light::EmissionTexture;
use crate::math::Frame;
use crate::shape::{SurfacePoint, TexCoord, TextureMapping};
use crate::texture::{Texture, TextureEvalContext};
use glam::{DVec2, DVec3, Vec3};

/// Least cosine between a shading normal and the geometric one.
const LEAST_COS: f32 = 0.05;

/// Least cosine to the viewer with which a cone's footprint still grows.
const GRAZING: f64 = 1e-3;

/// A colour that may follow a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tint {
    /// What the texture is multiplied by; without one, the colour.
    pub factor: Rgb,
    /// Index of the texture.
    pub texture: Option<u32>,
}

/// What of a material's scattering follows textures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coat {
    /// Nothing.
    Plain,
    /// Lambertian reflection.
    Diffuse(Tint),
    /// Phong's model.
    Phong {
        /// kd.
        diffuse: Tint,
        /// ks.
        specular: Tint,
        /// The exponent.
        shininess: f32,
    },
    /// Perfect reflection.
    Mirror(Tint),
    /// A metal.
    Conductor {
        /// Refractive index.
        eta: Rgb,
        /// Its imaginary part.
        k: Rgb,
        /// Texture of the roughness α.
        roughness: u32,
    },
    /// The boundary of a body, by the texture of its roughness α.
    Boundary(u32),
    /// A sheet without thickness.
    Thin {
        /// Index.
        eta: f32,
        /// What it lets through.
        transmittance: Tint,
    },
    /// The share of the second of a mix, by a texture.
    Mix(u32),
}

/// What tilts shading normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// Nothing.
    Smooth,
    /// A texture of heights.
    Bumps {
        /// The texture.
        texture: u32,
        /// Height of value 1 \[length].
        height: f32,
    },
    /// A texture of normals: red along growing u, green along growing v, blue outwards, each from −1 at 0 to 1 at 1.
    Normals(u32),
}

/// What a material wears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dress {
    /// Its scattering.
    pub coat: Coat,
    /// Its normals.
    pub relief: Relief,
}

/// A place as textures see it, with what tells neighbouring places.
struct Patch<'a> {
    place: TextureEvalContext,
    mapped: TexCoord,
    chart: &'a TextureMapping,
}

impl Patch<'_> {
    /// The place a step along the surface away.
    fn moved(&self, step: DVec3) -> TextureEvalContext {
        let uv = self.place.uv + DVec2::new(self.mapped.du.dot(step), self.mapped.dv.dot(step));
        TextureEvalContext { uv, p: self.place.p + self.chart.step_in_object(step), ..self.place }
    }

    /// How long a step along unit `direction` is that changes what `texture` goes by by its grain, and not less than half the patch.
    fn step(&self, texture: &Texture, direction: DVec3, width: f64) -> f64 {
        let change = if texture.is_solid() {
            self.chart.step_in_object(direction).length()
        } else {
            libm::hypot(self.mapped.du.dot(direction), self.mapped.dv.dot(direction))
        };
        let grain = if change > 0.0 { texture.grain() / change } else { 0.0 };
        grain.max(0.5 * width)
    }
}

impl Tint {
    /// Without a texture.
    #[must_use]
    pub fn plain(factor: Rgb) -> Self {
        Self { factor, texture: None }
    }

    fn at(&self, scene: &Scene, place: &TextureEvalContext) -> Rgb {
        self.texture.map_or(self.factor, |texture| self.factor * scene.textures[texture as usize].color(place))
    }
}

impl Scene {
    /// The place of a hit as textures see it, over the cone's footprint: as wide as the cone across the ray, and longer along it by
    /// the cosine to the normal.
    fn patch<'a>(&'a self, hit: &Hit, point: &SurfacePoint, wo: Vec3, cone: &RayCone) -> Patch<'a> {
        let (chart, own): (u32, &dyn Fn() -> TexCoord) = match hit.kind {
            HitKind::Triangle(i, b) => {
                let part = self.triangle_part[i as usize] as usize;
                (self.parts[part].1.chart, &move || self.mesh.mapped(i as usize, b))
            }
            HitKind::Shape(i, uv) => {
                (self.shape_attributes[i as usize].chart, &move || self.shapes[i as usize].mapped(point.p, uv))
            }
            HitKind::Plane(i) => (self.planes[i as usize].1.chart, &TexCoord::default),
        };
        let chart = &self.charts[chart as usize];
        let p = chart.in_object(point.p);
        let mapped = chart.at(p, own);
        let mut place = TextureEvalContext::sharp(mapped.uv, p);
        let width = f64::from(cone.width());
        if width > 0.0 {
            let (wo, n) = (wo.as_dvec3(), point.ng.as_dvec3());
            let along = wo - n * wo.dot(n);
            // Straight from above any direction will do.
            let along = along.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
            let long = along * (width / wo.dot(n).abs().max(GRAZING));
            let across = n.cross(along) * width;
            place.axes = [across, long].map(|x| DVec2::new(mapped.du.dot(x), mapped.dv.dot(x)));
            let [a, b] = [across, long].map(|x| chart.step_in_object(x).length());
            place.width = (a * b).sqrt();
        }
        Patch { place, mapped, chart }
    }

    /// Radiance of an area light that was hit.
    #[inline(never)]
    pub(super) fn glow(
        &self,
        glow: &EmissionTexture,
        hit: &Hit,
        point: &SurfacePoint,
        wo: Vec3,
        cone: &RayCone,
    ) -> Rgb {
        glow.radiance(&self.patch(hit, point, wo, &cone.of_lights()).place)
    }

    /// What a mix whose share may follow a texture stands for this time.
    #[inline(never)]
    pub(super) fn chosen_by_texture(&self, index: u32, chance: f32, place: &dyn Fn() -> TextureEvalContext) -> u32 {
        let coat = |material: &Material| material.dress.map(|dress| self.dresses[dress as usize].coat);
        self.chosen(index, chance, |material, amount| match coat(material) {
            Some(Coat::Mix(texture)) => self.textures[texture as usize].number(&place()),
            _ => amount,
        })
    }

    /// The place of a hit as textures see it, by a cone that has come to it.
    #[must_use]
    pub fn place(&self, hit: &Hit, point: &SurfacePoint, wo: Vec3, cone: &RayCone) -> TextureEvalContext {
        self.patch(hit, point, wo, cone).place
    }

    /// Gives `surface` what its dress makes of it.
    #[inline(never)]
    pub(super) fn put_on(&self, dress: u32, surface: &mut SurfaceInteraction<'_>, hit: &Hit, cone: &RayCone) {
        let Dress { coat, relief } = self.dresses[dress as usize];
        let patch = self.patch(hit, &surface.point, surface.wo, cone);
        if cone.effects.has(Effect::Textures) {
            self.put_on_coat(coat, surface, &patch.place);
        }
        if cone.effects.has(Effect::Bump) && relief != Relief::Smooth {
            let ns = self.tilted(relief, &surface.point, &patch, f64::from(cone.width()));
            surface.point.ns = ns;
        }
    }

    fn put_on_coat(&self, coat: Coat, surface: &mut SurfaceInteraction<'_>, place: &TextureEvalContext) {
        let number = |texture: u32| self.textures[texture as usize].number(place);
        match coat {
            Coat::Plain | Coat::Mix(_) => {}
            Coat::Diffuse(reflectance) => surface.bsdf = Bsdf::Diffuse(reflectance.at(self, place)),
            Coat::Phong { diffuse, specular, shininess } => {
                let (diffuse, specular) = (diffuse.at(self, place), specular.at(self, place));
                surface.bsdf = phong(diffuse, specular, shininess);
            }
            Coat::Mirror(reflectance) => surface.bsdf = Bsdf::Mirror(reflectance.at(self, place)),
            Coat::Conductor { eta, k, roughness } => {
                let sharp = TextureEvalContext::sharp(place.uv, place.p);
                let exact = self.textures[roughness as usize].number(&sharp);
                surface.bsdf = Bsdf::Conductor(Conductor::new(eta, k, of_the_kind_of(exact, number(roughness))));
            }
            Coat::Boundary(roughness) => surface.roughness = number(roughness),
            Coat::Thin { eta, transmittance } => {
                surface.bsdf = Bsdf::Thin(Thin { eta, transmittance: transmittance.at(self, place) });
            }
        }
        if let (Coat::Boundary(_), Scattering::Boundary(Body { index, .. })) = (coat, surface.material.scattering) {
            surface.bsdf = Bsdf::dielectric(index, surface.roughness);
        }
    }

    /// The shading normal under a relief: in the half space of the geometric one.
    fn tilted(&self, relief: Relief, point: &SurfacePoint, patch: &Patch<'_>, width: f64) -> Vec3 {
        let n = point.ns.as_dvec3();
        let tilted = match relief {
            Relief::Smooth => return point.ns,
            Relief::Bumps { texture, height } => {
                let texture = &self.textures[texture as usize];
                let frame = Frame::around(point.ns);
                let slope = |direction: Vec3| {
                    let direction = direction.as_dvec3();
                    let step = direction * patch.step(texture, direction, width);
                    let value = |step: DVec3| f64::from(texture.number(&patch.moved(step)));
                    let slope = f64::from(height) * (value(step) - value(-step)) / (2.0 * step.length());
                    if slope.is_finite() { direction * slope } else { DVec3::ZERO }
                };
                // The normal of p + h(p)·n, by the gradient of h along the surface (Blinn 1978).
                n - slope(frame.s) - slope(frame.t)
            }
            Relief::Normals(texture) => {
                let [x, y, z] = (self.textures[texture as usize].color(&patch.place).as_dvec3() * 2.0 - 1.0).to_array();
                match tangents(&patch.mapped, n) {
                    Some([u, v]) => u * x + v * y + n * z,
                    None => n,
                }
            }
        };
        let (ns, ng) = (tilted.try_normalize().unwrap_or(n).as_vec3(), point.ng);
        let cos = ns.dot(ng);
        if cos >= LEAST_COS {
            return ns;
        }
        // The direction of the tilt stays, its size does not.
        let along = (ns - ng * cos).normalize_or_zero();
        (along * (1.0 - LEAST_COS * LEAST_COS).sqrt() + ng * LEAST_COS).normalize()
    }

    /// How the course's shading sees a surface that was hit.
    #[must_use]
    pub fn look(&self, surface: &SurfaceInteraction<'_>, hit: &Hit, cone: &RayCone) -> PhongAppearance {
        let plain = surface.material.look;
        let Some(dress) = surface.material.dress.filter(|_| cone.effects.has(Effect::Textures)) else { return plain };
        let at = |tint: &Tint| tint.at(self, &self.place(hit, &surface.point, surface.wo, cone));
        match &self.dresses[dress as usize].coat {
            Coat::Diffuse(tint) | Coat::Mirror(tint) | Coat::Thin { transmittance: tint, .. } => {
                PhongAppearance::matt(at(tint))
            }
            Coat::Phong { diffuse, specular, .. } => {
                PhongAppearance { diffuse: at(diffuse), specular: at(specular), ..plain }
            }
            Coat::Plain | Coat::Conductor { .. } | Coat::Boundary(_) | Coat::Mix(_) => plain,
        }
    }
}

/// The roughness `alpha`, but on the same side of what divides casters from receivers as `exact`: which of them a surface is must
/// not depend on who looks, as photons and walks share the light between them by it.
fn of_the_kind_of(exact: f32, alpha: f32) -> f32 {
    if exact > STORED_ALPHA { alpha.max(STORED_ALPHA.next_up()) } else { alpha.min(STORED_ALPHA) }
}

/// Unit directions along the surface across `n` of growing u, and across it on the side of growing v; `None` where coordinates tell no
/// direction.
fn tangents(mapped: &TexCoord, n: DVec3) -> Option<[DVec3; 2]> {
    // v stays as it is across its gradient.
    let across = mapped.dv.cross(n).try_normalize()?;
    let u = if across.dot(mapped.du) < 0.0 { -across } else { across };
    let v = n.cross(u);
    Some([u, if v.dot(mapped.dv) < 0.0 { -v } else { v }])
}
