//! Checks the reasons that a plan states for a scene: from the parts of the scene's sketch, and by
//! brute-force tracing.

use super::sketch::{Light, LightKind, Material, MediumSketch, Object, Sketch};
use caustica::color::Rgb;
use caustica::light::Light as Resolved;
use caustica::photon::{PhotonSource, PhotonTracer, StoreMask};
use caustica::plan::{EffectReason, Plan};
use caustica::sampling::{Dimension, Key, Purpose, sobol_2d};
use caustica::scene::{Effect, Scene};
use glam::DVec3;

/// Number of photon paths that are traced to find out whether light reaches a specular object.
const PHOTONS: u32 = 4096;

/// Number of points of a light that are tested against specular objects.
const LIGHT_POINTS: u32 = 16;

/// Returns a message if the plan switches an effect off for a reason that is false; else `None`.
pub fn plan_contradiction(sketch: &Sketch, scene: &Scene, plan: &Plan) -> Option<String> {
    let off = plan.decisions.iter().filter(|d| !d.is_simulated);
    let wrong = off.filter(|d| !is_true(sketch, scene, plan, d.reason));
    let wrong: Vec<String> = wrong.map(|d| format!("{} is off because {}", d.effect, d.reason)).collect();
    (!wrong.is_empty()).then(|| wrong.join("; "))
}

fn is_true(sketch: &Sketch, scene: &Scene, plan: &Plan, reason: EffectReason) -> bool {
    let all: Vec<&Object> = sketch.objects.iter().filter(|o| !has_no_effect(sketch, o)).collect();
    let any = |is: &dyn Fn(&Material) -> bool| all.iter().any(|o| sketch.is_of(o, is));
    let emits = |light: &Light| light.strength != DVec3::ZERO;
    let panel = |object: &Object| match sketch.materials[object.material] {
        Material::Panel(a, b) => a + b != DVec3::ZERO,
        _ => false,
    };
    let any_emission = all.iter().any(|object| object.emission != DVec3::ZERO || panel(object));
    let media = sketch.media();
    let murky = media.iter().any(|stuff| stuff.scatters());
    match reason {
        EffectReason::NoLight => !any_emission && !sketch.lights.iter().any(emits),
        EffectReason::NoCaster => !any(&casts),
        EffectReason::NoLitCaster => casters_are_dark(sketch, scene),
        EffectReason::NoReceiver => !any(&receives) && !murky,
        EffectReason::BlackReceivers => !any(&scatters) && !murky,
        EffectReason::OneFlatObject if media.iter().any(|stuff| *stuff != MediumSketch::Nothing) => false,
        EffectReason::OneFlatObject => {
            let lamps = sketch.lights.iter().filter(|l| l.is_object()).count();
            all.len() + lamps == 1 && all.iter().all(|o| o.shape.is_flat())
                || all.is_empty()
                    && lamps == 1
                    && !sketch.lights.iter().any(|l| matches!(l.kind, LightKind::Sphere(..)))
        }
        EffectReason::NoSoftLight => {
            let soft = |l: &Light| l.is_object() || matches!(l.kind, LightKind::Environment);
            !any_emission && !sketch.lights.iter().any(|l| emits(l) && soft(l))
        }
        EffectReason::NoEnvironmentLight => !sketch.lights.iter().any(|l| matches!(l.kind, LightKind::Environment)),
        EffectReason::NoBody => sketch.filling.is_none() && !any(&is_body),
        EffectReason::NoMedium => media.iter().all(|stuff| *stuff == MediumSketch::Nothing),
        EffectReason::NoDispersion => !any(&|m| matches!(m, Material::Prism(_))),
        EffectReason::NoLens => !sketch.camera.contains("aperture"),
        EffectReason::NothingMoves => !sketch.moves(),
        EffectReason::NoTexture => {
            let textured = |m: &Material| matches!(m, Material::Patterned(..) | Material::RoughMap(..));
            let masks = all.iter().any(|o| sketch.has_mask(o.material));
            !any(&textured) && !masks && !all.iter().any(|o| o.emission == DVec3::ZERO && panel(o))
        }
        EffectReason::NoBump => !any(&|m| matches!(m, Material::Bumpy(..))),
        EffectReason::RequiredEffectUnneeded(other) => is_off(plan, other),
        EffectReason::Objects(..)
        | EffectReason::Lights(..)
        | EffectReason::EnvironmentLight
        | EffectReason::MayOcclude
        | EffectReason::Lens
        | EffectReason::Moving
        | EffectReason::Media(_)
        | EffectReason::AmbientMedium
        | EffectReason::UnsupportedByAlgorithm => false,
    }
}

/// Returns true if an object has no effect on light, as if it were air.
///
/// In an ambient medium, such an object displaces the medium, so the result is false.
fn has_no_effect(sketch: &Sketch, object: &Object) -> bool {
    let air = matches!(sketch.materials[object.material], Material::Dielectric(index, absorbed, ..) if index == 1.0 && absorbed == DVec3::ZERO);
    air && object.emission == DVec3::ZERO && sketch.filling.is_none()
}

fn is_off(plan: &Plan, effect: Effect) -> bool {
    plan.decisions.iter().any(|d| d.effect == effect && !d.is_simulated)
}

impl Light {
    /// Returns true if the light has a surface, which can also occlude.
    pub fn is_object(&self) -> bool {
        matches!(self.kind, LightKind::Sphere(..) | LightKind::Disc(..) | LightKind::Rectangle(..))
    }
}

fn is_body(material: &Material) -> bool {
    matches!(material, Material::Dielectric(..) | Material::Clear(_) | Material::Filled(..) | Material::Prism(_))
}

fn receives(material: &Material) -> bool {
    match material {
        Material::Diffuse(_) | Material::Phong(..) => true,
        Material::Patterned(..) | Material::Bumpy(..) | Material::Panel(..) => true,
        Material::Conductor(roughness) => *roughness > 0.3,
        Material::RoughMap(a, b) => a.max(*b) > 0.3,
        Material::Mirror(_) | Material::Dielectric(..) | Material::Thin(_) => false,
        Material::Clear(_) | Material::Filled(..) | Material::Prism(_) => false,
        Material::Mix(..) | Material::Mask(..) => false,
    }
}

fn scatters(material: &Material) -> bool {
    match material {
        Material::Diffuse(reflectance) => *reflectance != DVec3::ZERO,
        Material::Patterned(a, b) => *a + *b != DVec3::ZERO,
        Material::Phong(diffuse, specular, _) => *diffuse != DVec3::ZERO || *specular != DVec3::ZERO,
        other => receives(other),
    }
}

fn casts(material: &Material) -> bool {
    match material {
        Material::RoughMap(a, b) => a.min(*b) <= 0.3,
        Material::Clear(_) => false,
        other => !receives(other),
    }
}

/// Returns true if light reaches no specular object.
///
/// Light reaches none if no traced photon path hits one, and if each point on one is unlit even
/// without the other objects.
fn casters_are_dark(sketch: &Sketch, scene: &Scene) -> bool {
    if let Some(source) = PhotonSource::emitting_in_all_directions(scene) {
        let tracer = PhotonTracer { scene, source: &source, mask: StoreMask::CAUSTIC, max_bounces: 10 };
        if !tracer.trace(Key::new(1), PHOTONS, &|_| {}).deposits.surface_photons.is_empty() {
            return false;
        }
    }
    let casters = sketch.objects.iter().filter(|o| sketch.is_of(o, &casts) && !has_no_effect(sketch, o));
    let points = casters.flat_map(|o| o.shape.points()).map(|p| (p - scene.origin()).as_vec3());
    let key = Key::new(2).purpose_key(Purpose::Test);
    let reaches = |light: &Resolved, p| {
        let looks = (0..LIGHT_POINTS).map(|i| sobol_2d(i, key, Dimension::LightPosition));
        looks.filter_map(|u| light.sample_li(p, u)).any(|s| s.weight != Rgb::ZERO)
    };
    points.into_iter().all(|p| !scene.lights().iter().any(|light| reaches(light, p)))
}
