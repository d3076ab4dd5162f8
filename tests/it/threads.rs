//! One seed gives one image, with any number of threads, and for single passes.

use crate::support::scene_from_text_in;
use caustica::color::Rgb;
use caustica::integrate::{Algorithm, CameraPathSettings, PassResult, PhotonReport, Settings, SilentMonitor};
use caustica::scene::Scene;
use caustica::stats::Counters;

/// Scene with glass, a mirror, a mesh, a Phong material and an area light.
///
/// It has more lights than next-event estimation samples at once.
const TEXT: &str = "
PerspectiveCamera { center 0 1.4 5  lookAt 0 .7 0  angle 40  width 50  height 38 }
Background { color .1 .2 .3 }
Lights {
    RectangleLight { corner -1 4 -1  edge0 2 0 0  edge1 0 0 2  power 40 40 40 }
    PointLight { position 2 3 2  intensity 3 2 1 }
    SpotLight { position -2 3 2  lookAt 0 0 0  angle 50  penumbra 10  power 9 9 20 }
    SphereLight { center 1.5 2.5 -1  radius .2  power 9 3 3 }
    DirectionalLight { direction -.3 -1 -.2  irradiance .5 .5 .4 }
    DiscLight { center 0 3 3  normal 0 -1 -1  radius .3  radiance 5 9 5 }
}
Materials {
    Diffuse floor { reflectance .7 .6 .5 }
    Dielectric glass { indexOfRefraction 1.5  tint .8 .9 1  tintDistance 1 }
    Phong shiny { diffuseColor .4 .2 .1  specularColor .5 .5 .5  shininess 30 }
    Mirror silver { reflectance .9 .9 .9 }
}
Group {
    MaterialName floor  Rectangle { corner -4 0 4  edge0 8 0 0  edge1 0 0 -8 }
    Rectangle { corner -4 0 -4  edge0 8 0 0  edge1 0 5 0 }  Rectangle { corner -4 0 4  edge0 0 0 -8  edge1 0 5 0 }
    MaterialName glass  Sphere { center .8 .6 1 radius .6 }
    MaterialName shiny  Transform { Translate -.9 .8 0 UniformScale .7 TriangleMesh { obj_file mesh/knot.obj } }
    MaterialName silver  Sphere { center .9 .5 -1.2 radius .5 }
}";

/// Number of photon paths per pass. It is not a multiple of the paths of a chunk, so the last chunk
/// is short.
const PHOTONS: u32 = 30_001;

fn scene() -> Scene {
    scene_from_text_in("", TEXT)
}

fn settings() -> Settings {
    Settings {
        unaimed_paths: PHOTONS,
        aimed_paths: PHOTONS,
        camera_paths: CameraPathSettings {
            samples_per_pixel: Some(2),
            max_bounces: 50,
            seed: 7,
            ..CameraPathSettings::default()
        },
        ..Settings::default()
    }
}

/// All results of a pass except its times: pixel bits, counters, and reports of both photon maps.
type Result = (Vec<[u32; 3]>, Counters, PhotonReport, PhotonReport);

fn result(pass: PassResult) -> Result {
    let bits = |p: &Rgb| p.to_array().map(f32::to_bits);
    (pass.image.iter().map(bits).collect(), pass.counters, pass.unaimed, pass.aimed)
}

/// Renders passes on `threads` threads. Returns the bits of both gather radii, and the results of
/// the passes.
fn run(threads: usize, passes: impl IntoIterator<Item = u32> + Send) -> ([u32; 2], Vec<Result>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let scene = scene();
        let integrator = Algorithm::Sppm.prepare(&scene, settings());
        let radii = integrator.initial_gather_radii().unwrap();
        let passes = passes.into_iter().map(|i| result(integrator.render_pass(i, &SilentMonitor))).collect();
        ([radii.indirect.to_bits(), radii.caustic.to_bits()], passes)
    })
}

#[test]
fn any_thread_count_gives_same_bits() {
    let one = run(1, 0..3);
    let (_, passes) = &one;
    for (image, counters, global, caustic) in passes {
        // These checks ensure that the scene exercises every counter. A black image would be equal
        // with any number of threads.
        assert!(image.iter().flatten().filter(|bits| **bits != 0).count() > image.len());
        assert!(counters.continuation_rays > 0 && counters.shadow_rays > 0 && counters.gathered_photons > 0);
        assert!(global.stored_photons > 1000 && caustic.stored_photons > 1000 && counters.rejected_samples == 0);
        assert_eq!((global.emitted_paths, caustic.emitted_paths), (PHOTONS.into(), PHOTONS.into()));
    }
    assert!(passes[0] != passes[1] && passes[1] != passes[2], "passes are independent");
    for threads in [2, 3, 8] {
        assert!(run(threads, 0..3) == one, "{threads} threads");
    }
}

#[test]
fn single_pass_equals_pass_of_full_run() {
    let (radii, passes) = run(2, 0..4);
    let (radii_alone, alone) = run(2, [3]);
    assert_eq!(radii, radii_alone);
    assert!(passes[3..] == alone);
    assert!(passes[2..3] != alone);
}
