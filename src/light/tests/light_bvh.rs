//! Tests of light sampling with a bounding volume hierarchy.

use super::chi_square::{chi_square_p_value, sidak_significance_level};
use super::direct::{mesh_light_surface, three_triangle_mesh};
use super::intensity_maps::{test_goniometric_light, test_projector_light};
use super::*;
use crate::color;
use crate::sampling::DiscreteDistribution;

fn random_vector(k: Key) -> Vec3 {
    let (a, b) = (k.uniform_2d(Dimension::LightPosition), k.uniform_2d(Dimension::LightTarget));
    a.extend(b.x) * 2.0 - Vec3::ONE
}

/// `n` random lights of all kinds that have a position, in a box. Their strengths vary by a factor
/// of 1000.
fn random_finite_lights(n: u64) -> Vec<Light> {
    let (projector, goniometric) = (test_projector_light(), test_goniometric_light());
    let light = |i: u64| {
        let k = test_key(i).child_key(77);
        let place = random_vector(k) * Vec3::new(10.0, 3.0, 10.0);
        let axis = warp::square_to_uniform_sphere(k.uniform_2d(Dimension::LightDirection));
        let strength = libm::powf(10.0, 3.0 * k.uniform_1d(Dimension::Light) - 2.0);
        let center = place.as_dvec3();
        let (s, t) = axis.as_dvec3().any_orthonormal_pair();
        let spot = |outer_one_minus_cos: f32| {
            let peak = Rgb::splat(strength);
            Light::Spot(SpotLight {
                position: place,
                axis,
                inner_one_minus_cos: 0.1,
                outer_one_minus_cos,
                peak_intensity: peak,
            })
        };
        let kinds: [&dyn Fn() -> Light; 9] = [
            &|| Light::Point(PointLight { position: place, intensity: Rgb::splat(strength) }),
            &|| spot(0.4),
            // A spotlight without falloff: both cones are equal.
            &|| spot(0.1),
            &|| {
                let mut light = projector.clone();
                (light.position, light.scale) = (place, Rgb::splat(strength));
                Light::Projector(light)
            },
            &|| {
                let mut light = goniometric.clone();
                (light.position, light.scale) = (place, Rgb::splat(strength));
                Light::Goniometric(light)
            },
            &|| area_light(Shape::Sphere(SphereShape::new(center, 0.1)), 30.0 * strength),
            &|| area_light(Shape::Rectangle(Rectangle::new(center, s * 0.3, t * 0.2)), 15.0 * strength),
            &|| {
                let surface = mesh_light_surface(three_triangle_mesh(place));
                Light::Area(AreaLight::with_uniform_radiance(surface, Rgb::splat(strength)))
            },
            &|| area_light(Shape::Disc(Disc::circular_disc(center, axis.as_dvec3(), 0.2)), 8.0 * strength),
        ];
        kinds[i as usize % kinds.len()]()
    };
    (0..n).map(light).collect()
}

#[test]
fn random_lights_have_all_kinds_with_a_position() {
    let kind = |light: &Light| match light {
        Light::Point(_) => Some(0),
        Light::Spot(_) => Some(1),
        Light::Projector(_) => Some(2),
        Light::Goniometric(_) => Some(3),
        Light::Area(_) => Some(4),
        Light::Directional(_) | Light::Environment(_) => None,
    };
    let kinds: std::collections::BTreeSet<i32> = random_finite_lights(50).iter().filter_map(kind).collect();
    assert_eq!(kinds, (0..5).collect());
}

fn with_infinite_lights(mut lights: Vec<Light>) -> Vec<Light> {
    let directional = |direction| Light::Directional(DirectionalLight { direction, irradiance: Rgb::ONE });
    lights.insert(3, directional(Vec3::NEG_Y));
    lights.push(directional(Vec3::X));
    lights.push(Light::Point(PointLight { position: Vec3::ZERO, intensity: Rgb::ZERO }));
    lights
}

const ROOM: BoundingSphere = BoundingSphere { center: Vec3::ZERO, radius: 15.0 };

fn random_points_and_normals(n: u64) -> impl Iterator<Item = (Vec3, Option<Vec3>)> {
    (0..n).map(|i| {
        let k = test_key(i).child_key(5);
        let normal = warp::square_to_uniform_sphere(k.uniform_2d(Dimension::Film));
        (random_vector(k) * Vec3::new(12.0, 4.0, 12.0), (i % 3 > 0).then_some(normal))
    })
}

#[test]
fn light_probabilities_match_samples_and_sum_to_one() {
    let lights = with_infinite_lights(random_finite_lights(60));
    let choice = LightBvhSampler::new(&lights, ROOM).unwrap();
    let n = 20;
    for (p, normal) in random_points_and_normals(n) {
        let mut expected: Vec<f64> = (0..lights.len()).map(|i| f64::from(choice.probability(p, normal, i))).collect();
        let total: f64 = expected.iter().sum();
        // The sum may be far below 1 only where a normal excludes a group of lights.
        assert!(total < 1.0 + 1e-5 && (normal.is_some() || total > 1.0 - 0.1), "{total}");
        expected.push((1.0 - total).max(0.0));
        let draws = 100_000u64;
        let mut counts = vec![0.0; expected.len()];
        let mut remainders = vec![0.0; 16];
        for i in 0..draws {
            match choice.sample(p, normal, test_key(i).uniform_1d(Dimension::Light)) {
                Some((light, probability, remainder)) => {
                    assert_eq!(probability.to_bits(), choice.probability(p, normal, light).to_bits());
                    counts[light] += 1.0;
                    remainders[(remainder * 16.0) as usize] += 1.0;
                }
                None => counts[lights.len()] += 1.0,
            }
        }
        for e in &mut expected {
            *e *= draws as f64;
        }
        let uniform = vec![remainders.iter().sum::<f64>() / 16.0; 16];
        for chance in [chi_square_p_value(&counts, &expected), chi_square_p_value(&remainders, &uniform)] {
            assert!(chance > sidak_significance_level(2 * n as usize), "{p} {normal:?}: {chance}");
        }
    }
}

#[test]
fn infinite_lights_have_fixed_probability() {
    let lights = with_infinite_lights(random_finite_lights(10));
    let choice = LightBvhSampler::new(&lights, ROOM).unwrap();
    let p = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!([3, 11].map(|i| choice.probability(p, None, i)), [1.0 / 3.0; 2]);
    assert_eq!(choice.probability(p, None, 12), 0.0, "no power, no choice");
    let two = LightBvhSampler::new(&[lights[3].clone(), lights[11].clone()], ROOM).unwrap();
    assert_eq!(two.sample(p, None, 0.75), Some((1, 0.5, 0.5)));
    assert!(LightBvhSampler::new(&lights[12..], ROOM).is_none() && LightBvhSampler::new(&[], ROOM).is_none());
}

#[test]
fn contributing_lights_have_positive_probability() {
    let lights = random_finite_lights(100);
    let choice = LightBvhSampler::new(&lights, ROOM).unwrap();
    let mut shut_out = 0;
    for (p, normal) in random_points_and_normals(2000) {
        for (i, light) in lights.iter().enumerate() {
            if choice.probability(p, normal, i) > 0.0 {
                continue;
            }
            shut_out += 1;
            for j in 0..16 {
                let sample = light.sample_li(p, test_key(j).uniform_2d(Dimension::LightPosition));
                let cos = |wi: Vec3| normal.map_or(1.0, |n| n.dot(wi));
                assert!(sample.is_none_or(|s| cos(s.wi) <= 0.0), "{light:?} from {p} {normal:?}");
            }
        }
    }
    // At least a quarter of all pairs of point and light are excluded. Half of the flat lights face
    // away from a point, and half of all lights are below a surface's horizon.
    assert!(shut_out > 2000 * 100 / 4, "{shut_out}");
}

/// The light probabilities sum to 1 in three extreme cases: all lights at one position, lights in a
/// row, and lights at distances of powers of two, whose tree is a chain.
#[test]
fn degenerate_light_bvhs_contain_all_lights() {
    let at = |x: f32| Light::Point(PointLight { position: Vec3::new(x, 0.0, 0.0), intensity: Rgb::ONE });
    let sets: [Vec<Light>; 3] = [
        (0..1000).map(|_| at(1.0)).collect(),
        (0..1000).map(|i| at(i as f32)).collect(),
        (0..50).map(|i| at(libm::exp2f(i as f32 * 2.0 - 60.0))).collect(),
    ];
    for lights in sets {
        let choice = LightBvhSampler::new(&lights, ROOM).unwrap();
        let p = Vec3::new(0.5, 1.0, 0.0);
        let total: f32 = (0..lights.len()).map(|i| choice.probability(p, None, i)).sum();
        assert!((total - 1.0).abs() < 1e-4, "{total}");
    }
}

/// Relative variance of the irradiance at `p` with normal `n`, estimated from one sampled light,
/// for N ways of choosing the light.
///
/// `choices` give the probability of each light, by its index. With contribution fᵢ and probability
/// pᵢ of light i, the relative variance is (Σ E\[fᵢ²]/pᵢ − (Σ E\[fᵢ])²) / (Σ E\[fᵢ])².
fn relative_variances<const N: usize>(
    lights: &[Light],
    p: Vec3,
    n: Vec3,
    choices: [&dyn Fn(usize) -> f32; N],
) -> [f64; N] {
    let (mut mean, mut squares) = (0.0, [0.0; N]);
    let draws = 16;
    for (i, light) in lights.iter().enumerate() {
        for j in 0..draws {
            let sample = light.sample_li(p, test_key(j).uniform_2d(Dimension::LightPosition));
            let f = sample.map_or(0.0, |s| f64::from(s.weight.x * s.wi.dot(n).max(0.0)));
            if f > 0.0 {
                mean += f / draws as f64;
                for (square, choice) in squares.iter_mut().zip(choices) {
                    *square += f * f / (draws as f64 * f64::from(choice(i)));
                }
            }
        }
    }
    squares.map(|s| s / (mean * mean) - 1.0)
}

/// The light BVH gives less variance than sampling by power. The scenes are a thousand lights at
/// random positions in a room, and in rows under a ceiling.
#[test]
fn light_bvh_has_less_variance_than_power_sampling() {
    let lamp = |i: u64| DVec3::new((i % 32) as f64 - 16.0, 3.0, (i / 32) as f64 - 16.0);
    let down = |i| Rectangle::new(lamp(i), DVec3::X * 0.3, DVec3::Z * 0.3);
    let ceiling: Vec<Light> = (0..1000).map(|i| area_light(Shape::Rectangle(down(i)), 1.0)).collect();
    for (lights, up, least) in [(random_finite_lights(1000), false, 5.0), (ceiling, true, 20.0)] {
        let choice = LightBvhSampler::new(&lights, ROOM).unwrap();
        let powers =
            DiscreteDistribution::new(lights.iter().map(|l| f64::from(color::channel_mean(l.power(ROOM))))).unwrap();
        let mut gains: Vec<f64> = random_points_and_normals(60)
            .filter_map(|(p, normal)| {
                let n = if up { Vec3::Y } else { normal? };
                let p = if up { p.with_y(0.0) } else { p };
                let [tree, power] = relative_variances(
                    &lights,
                    p,
                    n,
                    [&|i| choice.probability(p, Some(n), i), &|i| powers.probability(i)],
                );
                (power / tree).is_finite().then_some(power / tree)
            })
            .collect();
        gains.sort_by(f64::total_cmp);
        let median = gains[gains.len() / 2];
        eprintln!("variance by power over variance by tree: median {median:.1}, least {:.1}", gains[0]);
        assert!(gains.len() > 30 && median > least && gains[0] > 1.0, "{median} {}", gains[0]);
    }
}
