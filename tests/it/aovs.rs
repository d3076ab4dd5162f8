//! Surface AOVs against closed forms, and light groups against the picture.

use crate::support::{course_data_folder, mean_and_error, scene_from_file, scene_from_text, student_t_tail};
use caustica::camera::{Filter, FilterKind};
use caustica::color::Rgb;
use caustica::format::SceneFile;
use caustica::integrate::{
    Algorithm, AovSurface, CameraPathSettings, LightGroup, PassResult, SURFACE_AOV_RAYS, Settings, SilentMonitor,
    SurfaceAovs, render_surface_aovs,
};
use caustica::scene::{Effects, Scene};
use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};

/// Algorithms that simulate light.
const SIMULATIONS: [Algorithm; 7] = [
    Algorithm::Hybrid,
    Algorithm::Path,
    Algorithm::Sppm,
    Algorithm::Ppm,
    Algorithm::Pm,
    Algorithm::Distributed,
    Algorithm::Whitted,
];

/// Returns settings of cheap passes with light groups.
fn grouped(filter: FilterKind) -> Settings {
    let camera_paths =
        CameraPathSettings { groups_light: true, filter: Filter::new(filter), ..CameraPathSettings::default() };
    Settings {
        camera_paths,
        unaimed_paths: 4000,
        aimed_paths: 4000,
        allows_ray_photon_balance: false,
        ..Settings::default()
    }
}

/// Fails unless the light groups of each pixel add up to the picture, up to rounding.
fn assert_groups_add_up(what: &str, pass: &PassResult) {
    assert_eq!(pass.light_groups.len(), LightGroup::ALL.len(), "{what}");
    for (i, pixel) in pass.image.iter().enumerate() {
        let parts: [DVec3; 3] = std::array::from_fn(|group| pass.light_groups[group][i].as_dvec3());
        let size = parts.iter().map(|part| part.abs().max_element()).sum::<f64>();
        let gap = (parts.iter().sum::<DVec3>() - pixel.as_dvec3()).abs().max_element();
        // A path adds some dozens of contributions, each with the rounding of f32.
        assert!(gap <= 64.0 * f64::from(f32::EPSILON) * size, "{what}, pixel {i}: {parts:?}, {pixel}");
    }
}

fn sum(pixels: &[Rgb]) -> f64 {
    pixels.iter().map(|pixel| f64::from(pixel.element_sum())).sum()
}

#[test]
fn light_groups_add_up_to_the_picture() {
    check_sums_of_groups(&["glass-ball", "lens-in-fog"], &SIMULATIONS);
}

#[test]
#[ignore = "long: light groups of many scenes"]
fn light_groups_of_many_scenes_add_up() {
    check_sums_of_groups(&["mirror-caustic", "god-rays", "motion", "prism", "textures", "sky", "milk"], &SIMULATIONS);
}

/// Checks the sums of light groups in small pictures of scenes of the repository.
fn check_sums_of_groups(scenes: &[&str], algorithms: &[Algorithm]) {
    for (name, filter) in
        scenes.iter().zip([FilterKind::Mitchell].into_iter().chain(std::iter::repeat(FilterKind::Box)))
    {
        let scene = scene_from_file(&format!("scenes/{name}.txt"), (16, 12));
        for algorithm in algorithms {
            let pass = algorithm.prepare(&scene, grouped(filter)).render_pass(1, &SilentMonitor);
            assert_groups_add_up(&format!("{name}, {}", algorithm.name()), &pass);
        }
    }
}

#[test]
fn light_groups_change_no_bit_of_the_picture() {
    let scene = scene_from_file("scenes/glass-ball.txt", (16, 12));
    for algorithm in SIMULATIONS {
        let with = grouped(FilterKind::BlackmanHarris);
        let mut without = with.clone();
        without.camera_paths.groups_light = false;
        let image = |settings| algorithm.prepare(&scene, settings).render_pass(0, &SilentMonitor).image;
        assert_eq!(image(with), image(without), "{}", algorithm.name());
    }
}

/// A lamp over a floor, beside a mirror that throws a caustic, under a small white ceiling.
const GROUPS: &str = "\
PerspectiveCamera { center 0 3 6  lookAt 0 0 0  angle 40  width 8  height 8 }
Background { color 0 0 0 }
Lights { RectangleLight { corner -.5 2 -.5  edge0 1 0 0  edge1 0 0 1  radiance 9 8 7 } }
Materials { Diffuse white { reflectance .7 .7 .7 }  Mirror silver { reflectance .9 .9 .9 } }
Group {
    MaterialName white
    Rectangle { corner -3 0 3  edge0 6 0 0  edge1 0 0 -6 }
    Rectangle { corner -3 0 -2  edge0 6 0 0  edge1 0 2 0 }
    MaterialName silver  Rectangle { corner 2 0 2  edge0 0 0 -4  edge1 0 3 0 }
}
";

/// Each group of an algorithm has the mean of that group in path tracing.
#[test]
#[ignore = "long: many samples by several integrators"]
fn algorithms_agree_on_each_light_group() {
    let scene = scene_from_text(GROUPS);
    let passes = 24;
    let groups_of_passes = |algorithm: Algorithm| -> Vec<[f64; 3]> {
        let settings = Settings { initial_gather_radius: Some(0.05), alpha: 1.0, ..grouped(FilterKind::Box) };
        let mut settings = Settings { unaimed_paths: 40_000, aimed_paths: 40_000, ..settings };
        settings.camera_paths.samples_per_pixel = Some(64);
        let integrator = algorithm.prepare(&scene, settings);
        let groups = |pass| {
            let pass = integrator.render_pass(pass, &SilentMonitor);
            std::array::from_fn(|group| sum(&pass.light_groups[group]))
        };
        (0..passes).map(groups).collect()
    };
    let expected = groups_of_passes(Algorithm::Path);
    for algorithm in [Algorithm::Hybrid, Algorithm::Sppm, Algorithm::Pm] {
        let found = groups_of_passes(algorithm);
        for group in LightGroup::ALL {
            let of_group =
                |passes: &[[f64; 3]]| -> Vec<f64> { passes.iter().map(|pass| pass[group as usize]).collect() };
            let ((a, a_error), (b, b_error)) =
                (mean_and_error(&of_group(&expected)), mean_and_error(&of_group(&found)));
            let error = a_error.hypot(b_error);
            // Gather discs blur light over edges of the picture by up to one percent.
            let excess = ((a - b).abs() - 0.01 * a).max(0.0);
            let p = student_t_tail(excess / error, f64::from(passes - 1));
            let line =
                format!("{} {}: {b:.4} ± {b_error:.4}, path {a:.4} ± {a_error:.4}", algorithm.name(), group.name());
            eprintln!("{line}");
            assert!(p > 1e-6, "{line}");
            assert!(error < 0.1 * a, "{line}: too blunt");
        }
    }
}

#[test]
fn light_without_bounces_is_direct() {
    let scene = scene_from_text(
        "PerspectiveCamera { center 0 0 5  lookAt 0 0 0  angle 40  width 16  height 16 }\n\
         Background { color .1 .2 .3 }\n\
         Lights { PointLight { position 3 3 3  intensity 20 20 20 } }\n\
         Materials { Diffuse white { reflectance .7 .7 .7 } }\n\
         Group { MaterialName white  Sphere { center 0 0 0  radius 1 } }\n",
    );
    for algorithm in SIMULATIONS {
        let pass = algorithm.prepare(&scene, grouped(FilterKind::Box)).render_pass(0, &SilentMonitor);
        assert_eq!(pass.light_groups[LightGroup::Direct as usize], pass.image, "{}", algorithm.name());
        assert_eq!(sum(&pass.light_groups[1]) + sum(&pass.light_groups[2]), 0.0);
    }
}

/// Returns the AOVs of `scene` with a box filter.
fn aovs_of(scene: &Scene, surface: AovSurface) -> SurfaceAovs {
    let settings = CameraPathSettings { filter: Filter::new(FilterKind::Box), ..CameraPathSettings::default() };
    render_surface_aovs(scene, Effects::ALL, &settings, surface, SURFACE_AOV_RAYS, &SilentMonitor).unwrap()
}

/// Returns the mean of `value` over directions through a pixel of a square pinhole picture. The
/// picture has `size` pixels on a side and a field of view of `angle` degrees.
///
/// The camera looks along −z. `None` if a direction has no value.
fn pixel_mean(size: u32, angle: f64, (x, y): (u32, u32), value: impl Fn(DVec3) -> Option<DVec3>) -> Option<DVec3> {
    let half = libm::tan(0.5 * angle.to_radians());
    let steps = 24;
    let coordinate = |pixel: u32, step: u32| {
        half * (2.0 * (f64::from(pixel) + (f64::from(step) + 0.5) / f64::from(steps)) / f64::from(size) - 1.0)
    };
    let (mut total, mut count) = (DVec3::ZERO, 0.0);
    for i in 0..steps * steps {
        let direction = DVec3::new(coordinate(x, i % steps), -coordinate(y, i / steps), -1.0).normalize();
        if let Some(value) = value(direction) {
            (total, count) = (total + value, count + 1.0);
        }
    }
    (count == f64::from(steps * steps)).then(|| total / count)
}

/// A course scene: a sphere of radius 1 squeezed to the half axes 1, 0.2 and 1, turned by 45°.
#[test]
fn normals_of_the_course_ellipsoid_are_exact() {
    let Some(course) = course_data_folder("testcases") else { return };
    let scene = SceneFile::read(&course.join("scene03_sphere.txt")).unwrap().resolve().unwrap();
    let aovs = aovs_of(&scene, AovSurface::FirstNonSpecular);
    let turn = glam::DMat3::from_rotation_z(45f64.to_radians());
    let axes = DVec3::new(1.0, 0.2, 1.0);
    let hit = |direction: DVec3| -> Option<(DVec3, DVec3)> {
        // Map the ellipsoid to the unit sphere.
        let (o, d) = (turn.transpose() * DVec3::new(0.0, 0.0, 10.0) / axes, turn.transpose() * direction / axes);
        let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
        let root = (b * b - a * c).sqrt();
        let t = (-b - root) / a;
        root.is_finite().then(|| (DVec3::new(0.0, 0.0, 10.0) + direction * t, turn * ((o + d * t) / axes).normalize()))
    };
    let mut checked = 0;
    for (y, x) in (0..200).flat_map(|y| (0..200).map(move |x| (y, x))) {
        let i = (y * 200 + x) as usize;
        let Some(normal) = pixel_mean(200, 20.0, (x, y), |d| hit(d).map(|(_, normal)| normal)) else { continue };
        if normal.z < 0.3 {
            // Near the silhouette the normal turns fast within a pixel.
            continue;
        }
        let depth = pixel_mean(200, 20.0, (x, y), |d| hit(d).map(|(p, _)| DVec3::splat((p.z - 10.0) / d.z))).unwrap();
        let position = pixel_mean(200, 20.0, (x, y), |d| hit(d).map(|(p, _)| p)).unwrap();
        checked += 1;
        assert!((aovs.normal[i].as_dvec3() - normal).length() < 0.02, "{x}, {y}: {} {normal}", aovs.normal[i]);
        assert!((f64::from(aovs.depth[i]) - depth.x).abs() < 0.005, "{x}, {y}: {} {}", aovs.depth[i], depth.x);
        assert!((aovs.position[i].as_dvec3() - position).length() < 0.005, "{x}, {y}: {}", aovs.position[i]);
        assert_eq!((aovs.object_id[i], aovs.material_id[i], aovs.albedo[i]), (1, 1, Vec3::ONE), "{x}, {y}");
    }
    assert!(checked > 1000, "{checked} pixels are inside the ellipsoid");
    let corner = (aovs.albedo[0], aovs.normal[0], aovs.depth[0], aovs.object_id[0], aovs.material_id[0]);
    assert_eq!(corner, (Vec3::new(0.2, 0.0, 0.6), Vec3::ZERO, 0.0, 0, 0), "the background");
}

/// A course scene: the plane y = −2 below five spheres, seen from z = 10.
#[test]
fn depth_of_the_course_plane_is_exact() {
    let Some(course) = course_data_folder("testcases") else { return };
    let scene = SceneFile::read(&course.join("scene01_basic.txt")).unwrap().resolve().unwrap();
    let aovs = aovs_of(&scene, AovSurface::FirstNonSpecular);
    for (x, y) in (180..200).flat_map(|y| (0..200).map(move |x| (x, y))) {
        let i = (y * 200 + x) as usize;
        let depth = pixel_mean(200, 30.0, (x, y), |d| Some(DVec3::splat(-2.0 / d.y))).unwrap().x;
        let found = f64::from(aovs.depth[i]);
        assert!((found / depth - 1.0).abs() < 1e-3, "{x}, {y}: {found}, expected {depth}");
        assert_eq!((aovs.normal[i], aovs.object_id[i], aovs.material_id[i]), (Vec3::Y, 6, 4), "{x}, {y}");
    }
    assert_eq!(aovs.object_id[100 * 200 + 100], 1, "the red sphere in the middle");
}

/// Builds a red square at z = −1 and a green square at z = −3, with further objects of scene text
/// `before`.
fn squares(before: &str) -> Scene {
    scene_from_text(&format!(
        "OrthographicCamera {{ center 0 0 5  direction 0 0 -1  up 0 1 0  size 2  width 16  height 16 }}\n\
         Background {{ color 0 0 0 }}\n\
         Lights {{ PointLight {{ position 0 0 4  intensity 20 20 20 }} }}\n\
         Textures {{ Checker tiles {{ color0 .1 .2 .3  color1 .9 .8 .7  scale 2 2 }} }}\n\
         Materials {{ Diffuse red {{ reflectance .7 .1 .1 }}  Diffuse green {{ reflectance .1 .6 .2 }}\n\
             Dielectric glass {{ indexOfRefraction 1.5 }}  Mirror silver {{ reflectance .5 .5 .5 }}\n\
             Diffuse tiled {{ reflectance tiles }} }}\n\
         Group {{ MaterialName red  Rectangle {{ corner -1 -1 -1  edge0 1 0 0  edge1 0 2 0 }}\n\
             MaterialName green  Rectangle {{ corner 0 -1 -3  edge0 1 0 0  edge1 0 2 0 }}\n\
             {before} }}\n"
    ))
}

/// Index of the pixel in column `x` of the middle row of [`squares`].
fn middle(x: usize) -> usize {
    8 * 16 + x
}

#[test]
fn identifiers_and_albedo_tell_objects_apart() {
    let aovs = aovs_of(&squares(""), AovSurface::FirstNonSpecular);
    let at =
        |x| (aovs.object_id[middle(x)], aovs.material_id[middle(x)], aovs.albedo[middle(x)], aovs.depth[middle(x)]);
    assert_eq!(at(3), (1, 1, Vec3::new(0.7, 0.1, 0.1), 6.0));
    assert_eq!(at(12), (2, 2, Vec3::new(0.1, 0.6, 0.2), 8.0));
    assert_eq!(aovs.position[middle(12)].z, -3.0);
}

#[test]
fn albedo_is_the_texture() {
    let scene = squares("MaterialName tiled  Rectangle { corner -1 -1 0  edge0 2 0 0  edge1 0 2 0 }");
    let aovs = aovs_of(&scene, AovSurface::FirstNonSpecular);
    let (dark, light) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.9, 0.8, 0.7));
    for (x, y, color) in [(3, 3, light), (12, 3, dark), (3, 12, dark), (12, 12, light)] {
        assert!((aovs.albedo[y * 16 + x] - color).length() < 1e-6, "{x}, {y}: {}", aovs.albedo[y * 16 + x]);
    }
}

#[test]
fn rays_follow_glass_to_objects_behind() {
    let scene = squares("MaterialName glass  Box { min -1.5 -1.5 1  max 1.5 1.5 2 }");
    let aovs = aovs_of(&scene, AovSurface::FirstNonSpecular);
    // At normal incidence a surface transmits 96 %; each pane reflects back and forth inside.
    let transmitted = 0.96 * 0.96;
    let albedo = aovs.albedo[middle(12)];
    let low = Vec3::new(0.1, 0.6, 0.2) * transmitted;
    assert!((low * 0.999).cmple(albedo).all() && albedo.cmple(low * 1.003).all(), "{albedo}");
    assert!((aovs.depth[middle(12)] - 8.0).abs() < 1e-4, "{}", aovs.depth[middle(12)]);
    assert_eq!((aovs.object_id[middle(12)], aovs.material_id[middle(12)]), (2, 2));
    let first = aovs_of(&scene, AovSurface::First);
    assert_eq!((first.object_id[middle(12)], first.material_id[middle(12)], first.depth[middle(12)]), (3, 3, 3.0));
}

#[test]
fn rays_follow_mirrors_to_reflected_objects() {
    // A mirror at 45° turns the view to the right, where a green square stands at x = 4.
    let mirror = "MaterialName silver  Rectangle { corner -1 -1 -1  edge0 2 0 2  edge1 0 2 0 }\n\
                  MaterialName green  Rectangle { corner -4 -1 -4  edge0 0 0 8  edge1 0 2 0 }";
    let scene = squares(mirror);
    let aovs = aovs_of(&scene, AovSurface::FirstNonSpecular);
    for x in [9, 12] {
        let i = middle(x);
        // The ray at x meets the mirror at z = x and then goes to x = −4.
        let at = (x as f32 + 0.5) / 8.0 - 1.0;
        assert!((aovs.depth[i] - (5.0 - at + at + 4.0)).abs() < 1e-4, "{}", aovs.depth[i]);
        assert!((aovs.position[i] - Vec3::new(-4.0, aovs.position[i].y, at)).length() < 0.01, "{}", aovs.position[i]);
        assert!((aovs.normal[i] - Vec3::X).length() < 1e-6, "{}", aovs.normal[i]);
        assert!((aovs.albedo[i] - 0.5 * Vec3::new(0.1, 0.6, 0.2)).length() < 1e-6, "{}", aovs.albedo[i]);
        assert_eq!((aovs.object_id[i], aovs.material_id[i]), (4, 2));
    }
    let first = aovs_of(&scene, AovSurface::First);
    assert_eq!((first.object_id[middle(12)], first.albedo[middle(12)]), (3, Vec3::splat(0.5)));
}

/// Builds a scene of moving objects, seen by a camera at z = 5 that looks along −z. Distances on
/// the film are exact in the middle column.
fn moving(camera: &str, objects: &str) -> Scene {
    scene_from_text(&format!(
        "{camera}\nBackground {{ color .1 .1 .1 }}\n\
         Lights {{ PointLight {{ position 0 0 4  intensity 20 20 20 }} }}\n\
         Materials {{ Diffuse red {{ reflectance .7 .1 .1 }}  Dielectric glass {{ indexOfRefraction 1.5 }} }}\n\
         Group {{ MaterialName red  {objects} }}\n"
    ))
}

const ORTHOGRAPHIC: &str =
    "OrthographicCamera { center 0 0 5  direction 0 0 -1  up 0 1 0  size 2  width 16  height 16 }";

#[test]
fn motion_of_a_shifted_square_is_exact() {
    // Eight pixels are one unit. The square covers the pixels of the middle all the time.
    let square = "Moving { Translate .5 .25 0  Rectangle { corner -.9 -.6 0  edge0 1.3 0 0  edge1 0 .9 0 } }\n\
                  Rectangle { corner .5 -1 -1  edge0 .5 0 0  edge1 0 2 0 }";
    let aovs = aovs_of(&moving(ORTHOGRAPHIC, square), AovSurface::FirstNonSpecular);
    assert!((aovs.motion[middle(6)] - Vec2::new(4.0, -2.0)).length() < 1e-5, "{}", aovs.motion[middle(6)]);
    assert_eq!(aovs.motion[2 * 16 + 14], Vec2::ZERO, "an object at rest");
    assert_eq!(aovs.motion[0], Vec2::ZERO, "the background");
    let behind_glass = "MaterialName glass  Box { min -1.5 -1.5 1  max 1.5 1.5 2 }";
    let scene = moving(ORTHOGRAPHIC, &format!("{square}\n{behind_glass}"));
    assert_eq!(aovs_of(&scene, AovSurface::FirstNonSpecular).motion[middle(6)], Vec2::ZERO, "the glass at rest");
}

#[test]
fn motion_of_a_turning_disc_is_exact() {
    let disc = "Moving { ZRotate 90  Disc { center 0 0 0  normal 0 0 1  radius 3 } }";
    let aovs = aovs_of(&moving(ORTHOGRAPHIC, disc), AovSurface::First);
    for (x, y) in [(2, 3), (8, 8), (15, 1)] {
        // A point that is seen at the time t has already turned by 90° · t, and will turn by 90° ·
        // (1 − t).
        let p = DVec2::new((f64::from(x) + 0.5) / 8.0 - 1.0, 1.0 - (f64::from(y) + 0.5) / 8.0);
        let by = |t: f64| {
            let turned = |degrees: f64| DMat2::from_angle(degrees.to_radians()) * p;
            turned(90.0 * (1.0 - t)) - turned(-90.0 * t)
        };
        let mean = (0..1000).map(|i| by((f64::from(i) + 0.5) / 1000.0)).sum::<DVec2>() / 1000.0;
        let found = aovs.motion[y as usize * 16 + x as usize].as_dvec2();
        // Rays are spread over the pixel; 32 of them leave an error of about a tenth of a pixel.
        assert!((found - 8.0 * DVec2::new(mean.x, -mean.y)).length() < 0.5, "{x}, {y}: {found} {mean}");
    }
}

#[test]
fn motion_shows_movements_of_the_camera() {
    let half = libm::tan(20f64.to_radians());
    let camera = |steps: &str| {
        format!(
            "Moving {{ {steps}  PerspectiveCamera {{ center 0 0 5  direction 0 0 -1  up 0 1 0  angle 40  width 16  height 16 }} }}"
        )
    };
    // The camera shifts by .5 to the right before a wall at distance 6, and a ball before the wall.
    let wall = "Rectangle { corner -9 -9 -1  edge0 18 0 0  edge1 0 18 0 }";
    let shifted = aovs_of(&moving(&camera("Translate .5 0 0"), wall), AovSurface::First).motion[middle(8)];
    let expected = -0.5 / (6.0 * 2.0 * half / 16.0);
    assert!((f64::from(shifted.x) - expected).abs() < 1e-4 && shifted.y.abs() < 1e-4, "{shifted}, {expected}");
    // The camera turns by 2° to the left. What it sees, near or far, moves to the right.
    for objects in [wall, ""] {
        let turned = aovs_of(&moving(&camera("YRotate 2"), objects), AovSurface::First).motion[middle(8)];
        // The ray at the film position x sees an angle of atan(x) in the middle of the turn.
        let x = half / 16.0;
        let angle = libm::atan(x);
        let turn = 1f64.to_radians();
        let expected = (libm::tan(angle + turn) - libm::tan(angle - turn)) / (2.0 * half / 16.0);
        assert!((f64::from(turned.x) / expected - 1.0).abs() < 0.01, "{objects}: {turned}, {expected}");
        assert!(turned.y.abs() < 0.01, "{objects}: {turned}");
    }
}
