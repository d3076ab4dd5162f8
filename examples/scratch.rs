use caustica::camera::*;
use caustica::integrate::*;
use caustica::photon::*;
use caustica::scene::*;
use caustica::shape::*;
use glam::*;
fn main() {
    let mut b = SceneBuilder::new();
    let white = b.material(Material::diffuse(Vec3::splat(0.75)));
    let red = b.material(Material::diffuse(Vec3::new(0.65, 0.08, 0.08)));
    let green = b.material(Material::diffuse(Vec3::new(0.10, 0.50, 0.12)));
    let black = b.material(Material::black());
    let glass = b.material(Material::dielectric(1.5, Vec3::ZERO));
    let mirror = b.material(Material::mirror(Vec3::splat(0.95)));
    let v = DVec3::new;
    let z = Vec3::ZERO;
    let mut r = |c, e0, e1, m, e| {
        b.shape(Shape::Rectangle(Rectangle::new(c, e0, e1)), m, e);
    };
    r(v(-1., 0., -1.), v(0., 0., 4.), v(2., 0., 0.), white, z);
    r(v(-1., 2., -1.), v(2., 0., 0.), v(0., 0., 4.), white, z);
    r(v(-1., 0., -1.), v(2., 0., 0.), v(0., 2., 0.), white, z);
    r(v(-1., 0., 3.), v(0., 2., 0.), v(2., 0., 0.), white, z);
    r(v(-1., 0., -1.), v(0., 2., 0.), v(0., 0., 4.), red, z);
    r(v(1., 0., -1.), v(0., 0., 4.), v(0., 2., 0.), green, z);
    r(v(-0.15, 1.98, -0.15), v(0.3, 0., 0.), v(0., 0., 0.3), black, Vec3::splat(60.0));
    b.shape(Shape::Sphere(Sphere::new(v(0.4, 0.45, 0.2), 0.35)), glass, z);
    b.shape(Shape::Sphere(Sphere::new(v(-0.4, 0.4, -0.35), 0.4)), mirror, z);
    let eye = v(0., 1.1, 2.9);
    let cam = Pinhole::new(eye, v(0., 0.85, 0.) - eye, DVec3::Y, 50f64.to_radians(), 256, 256).unwrap();
    let scene = b.build(cam).unwrap();
    let passes: u32 = std::env::args().nth(1).map_or(8, |a| a.parse().unwrap());
    let photons: u32 = std::env::args().nth(2).map_or(200_000, |a| a.parse().unwrap());
    let settings = PhotonSettings {
        photons,
        caustic_photons: photons,
        samples: 1,
        gather_k: 50,
        radius: None,
        kernel: Kernel::Epanechnikov,
        max_bounces: 100,
        seed: 1,
        filter: Filter::new(FilterKind::Box),
    };
    let t = std::time::Instant::now();
    let pm = PhotonMapping::new(&scene, settings);
    eprintln!("radii {:?} {:?}", pm.radii(), t.elapsed());
    let mut sum = vec![DVec3::ZERO; 256 * 256];
    for i in 0..passes {
        let p = pm.pass(i, &Silent);
        for (s, v) in sum.iter_mut().zip(&p.image) {
            *s += v.as_dvec3();
        }
        if i == 0 {
            eprintln!("{:?}\n{:?}\n{:?}\n{:?}", p.seconds, p.counters, p.global, p.caustic);
        }
    }
    eprintln!("{:?}", t.elapsed());
    let img: Vec<Vec3> = sum.iter().map(|s| (*s / passes as f64).as_vec3()).collect();
    let reference = caustica::image::read(std::path::Path::new("/work/shared/reference/cbox-caustic.exr")).unwrap();
    let mean = img.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / 65536.0;
    let rmean = reference.pixels().iter().map(|v| v.as_dvec3()).sum::<DVec3>() / 65536.0;
    let mut c = 0.0;
    for y in 210..=218 {
        for x in 177..=189 {
            c += img[y * 256 + x].element_sum() / 3.0;
        }
    }
    let err: f64 = img
        .iter()
        .zip(reference.pixels())
        .map(|(a, b)| {
            let d = (*a - *b).as_dvec3();
            let b = b.as_dvec3();
            ((d * d) / (b * b + 0.01)).min(DVec3::splat(10.0)).element_sum() / 3.0
        })
        .sum::<f64>()
        / 65536.0;
    eprintln!("mean {mean} ref {rmean} caustic {} err {err}", c / (9.0 * 13.0));
    let image = caustica::image::Image::from_pixels(256, 256, img).unwrap();
    caustica::image::write(std::path::Path::new("/tmp/cbox.png"), &image, &Default::default()).unwrap();
}
