use super::efficient_counts::MAX_RELATIVE_WORK;
use super::*;
use crate::integrate::test_scenes::glass_ball_above_plane;
use crate::integrate::{Settings, hybrid};
use crate::scene::Effects;
use glam::DVec3;

const SAMPLES: u32 = 4;
const WORK: PassWork = PassWork {
    camera_work_per_pixel: 40.0,
    photon_work_per_pixel: 10.0,
    work_per_prefix_ray: 2.0,
    work_per_lookup: 6.0,
};

/// Returns the variances of `n` ordinary pixels, and of one special pixel such as a highlight or a
/// caustic.
fn one_special_pixel(n: usize, special: RelativePixelVariances) -> Vec<RelativePixelVariances> {
    let ordinary = RelativePixelVariances {
        from_receiver: 0.1,
        up_to_receiver: 0.001,
        photon_estimate: 0.001,
        ..RelativePixelVariances::default()
    };
    let mut variances = vec![ordinary; n];
    variances.push(RelativePixelVariances { from_receiver: 0.1, ..special });
    variances
}

#[test]
fn only_pixels_with_noisy_prefixes_get_prefix_rays() {
    let highlight = RelativePixelVariances { up_to_receiver: 50.0, ..RelativePixelVariances::default() };
    let counts = efficient_ray_counts(&one_special_pixel(200, highlight), SAMPLES, &WORK).unwrap();
    let none = PixelPrefixRayCounts::default();
    assert!(counts[..200].iter().all(|count| *count == none));
    assert!(counts[200].unaimed > 8 && counts[200].lookups == 0, "{:?}", counts[200]);

    let caustic = RelativePixelVariances { photon_estimate: 50.0, ..RelativePixelVariances::default() };
    let counts = efficient_ray_counts(&one_special_pixel(200, caustic), SAMPLES, &WORK).unwrap();
    assert!(counts[200].unaimed > 8 && counts[200].lookups == counts[200].unaimed, "{:?}", counts[200]);

    let ordinary = RelativePixelVariances {
        up_to_receiver: 0.001,
        photon_estimate: 0.001,
        from_receiver: 0.1,
        ..RelativePixelVariances::default()
    };
    assert_eq!(efficient_ray_counts(&[ordinary; 200], SAMPLES, &WORK), None);
}

/// Twice or half as many prefix rays as the chosen numbers give a larger product of variance and
/// work.
#[test]
fn ray_counts_minimize_variance_times_work() {
    let special = RelativePixelVariances {
        up_to_receiver: 20.0,
        photon_estimate: 2.0,
        from_receiver: 0.1,
        ..RelativePixelVariances::default()
    };
    let variances = one_special_pixel(800, special);
    let PixelPrefixRayCounts { unaimed: rays, lookups, .. } =
        efficient_ray_counts(&variances, SAMPLES, &WORK).unwrap()[800];
    let product = |factor: f64| {
        let (m, l, n) = (f64::from(rays) * factor, f64::from(lookups) * factor, f64::from(SAMPLES));
        let rest_work = WORK.camera_work_per_pixel + WORK.photon_work_per_pixel;
        let v = variances[0];
        let ordinary =
            rest_work / WORK.camera_work_per_pixel * v.from_receiver / n + v.up_to_receiver / n + v.photon_estimate;
        let variance = 800.0 * ordinary
            + rest_work / WORK.camera_work_per_pixel * special.from_receiver / n
            + special.up_to_receiver / (n + m)
            + special.photon_estimate / (1.0 + l);
        variance * (801.0 * rest_work + m * WORK.work_per_prefix_ray + l * WORK.work_per_lookup)
    };
    let best = product(1.0);
    assert!(product(0.5) > best && product(2.0) > best, "{} {best} {}", product(0.5), product(2.0));
}

#[test]
fn prefix_ray_work_is_bounded() {
    let noisy = RelativePixelVariances {
        from_receiver: 0.1,
        up_to_receiver: 1e6,
        photon_estimate: 1e6,
        ..RelativePixelVariances::default()
    };
    let counts = efficient_ray_counts(&[noisy; 100], SAMPLES, &WORK).unwrap();
    let work: f64 = counts
        .iter()
        .map(|c| f64::from(c.unaimed) * WORK.work_per_prefix_ray + f64::from(c.lookups) * WORK.work_per_lookup)
        .sum();
    let limit = MAX_RELATIVE_WORK * (WORK.camera_work_per_pixel + WORK.photon_work_per_pixel) * 100.0;
    assert!(work > 0.5 * limit && work <= limit, "{work} of {limit}");
}

#[test]
fn undefined_variances_give_no_prefix_rays() {
    let broken = RelativePixelVariances {
        from_receiver: 0.1,
        up_to_receiver: f64::NAN,
        photon_estimate: f64::INFINITY,
        ..RelativePixelVariances::default()
    };
    assert_eq!(efficient_ray_counts(&[broken; 4], SAMPLES, &WORK), None);
    assert_eq!(efficient_ray_counts(&[RelativePixelVariances::default(); 4], SAMPLES, &WORK), None);
}

/// Small films have blocks of one pixel. In larger films, each pair of pictures traces one pixel of
/// each block, and each pixel of a whole block takes its turn.
#[test]
fn blocks_trace_each_of_their_pixels_in_turn() {
    let edges = [(1, 1), (640, 480), (1024, 512), (1025, 512), (1280, 960), (3840, 2160)];
    assert_eq!(edges.map(|size| PilotBlocks::new(size).edge), [1, 1, 1, 2, 2, 4]);
    assert_eq!(PilotBlocks::new((20, 30)).traced_pixel(599, 3), 599);
    for edge in [2, 3, 4] {
        let blocks = PilotBlocks { edge, film_size: (13, 11) };
        let mut traced = vec![0; 13 * 11];
        for i in 0..(edge * edge) as u32 {
            for block in 0..blocks.count() {
                let pixel = blocks.traced_pixel(block, 2 * i);
                assert_eq!(blocks.traced_pixel(block, 2 * i + 1), pixel);
                assert_eq!(blocks.block_of_pixel(pixel), block);
                traced[pixel] += 1;
            }
        }
        let is_whole = |pixel: usize| pixel % 13 / edge < 13 / edge && pixel / 13 / edge < 11 / edge;
        assert!((0..13 * 11).filter(|pixel| is_whole(*pixel)).all(|pixel| traced[pixel] == 1), "{edge}");
        assert!(traced.iter().all(|count| *count > 0), "{edge}");
    }
}

/// All pixels of a block get the variance of the block's pictures. This variance leaves out the
/// difference between the pixels that the pictures trace.
#[test]
fn pixels_share_the_variances_of_their_block() {
    let blocks = PilotBlocks { edge: 2, film_size: (5, 3) };
    let pixel_counts: Vec<usize> = (0..blocks.count()).map(|block| blocks.pixel_count(block)).collect();
    assert_eq!(pixel_counts, [4, 4, 2, 2, 2, 1]);
    let mut light = vec![BlockLightStatistics::default(); blocks.count()];
    for light in &mut light {
        [0.9, 1.1].iter().for_each(|value| light.from_receiver.add(*value));
        [0.0, 0.0].iter().for_each(|value| light.up_to_receiver.add(*value));
        // Two pixels with different light, each with a variance of 0.02.
        [1.0, 1.2].iter().for_each(|value| light.photon_estimate.add(*value));
        light.photon_estimate.start_group();
        [5.0, 5.2].iter().for_each(|value| light.photon_estimate.add(*value));
    }
    let variances = pixel_variances(&light, &[], &blocks).unwrap();
    assert_eq!(variances.len(), 15);
    // The light is 1 + 3.1, so L̃·(L + L̃) is 2·4.1².
    for v in &variances {
        let expected = 0.02 / (2.0 * 4.1 * 4.1);
        assert!((v.from_receiver / expected - 1.0).abs() < 1e-5 && (v.photon_estimate / expected - 1.0).abs() < 1e-5);
        assert_eq!((v.up_to_receiver, v.lamp_images_aimed), (0.0, 0.0));
    }
}

/// With blocks, fewer pixels are traced, but the work of a pass and of a ray is the same.
///
/// The ratio compares means over 6,144 and over 1,536 paths. If the spread of the work of a path is
/// its mean, the standard error is √(1/6144 + 1/1536) = 2.9 %, and the bound five times as large. A
/// factor of 4, the pixels of a block, would exceed it.
#[test]
fn blocks_do_not_change_the_measured_work() {
    let scene = glass_ball_above_plane(DVec3::new(0.0, 2.0, 4.0), DVec3::new(0.0, -0.5, -1.0));
    let settings = Settings { aimed_paths: 20_000, ..Settings::default() };
    let renderer = PassRenderer::new(&scene, settings.clone(), hybrid::path_policy(Effects::ALL, &settings));

    let mut photons = PassResult::default();
    let options = MapBuildOptions { connects_to_camera: true, ..MapBuildOptions::for_pilot(Key::new(1), 4) };
    let maps = renderer.map_builder.build(&options, &SilentMonitor, &mut photons);
    let no_images = images_of_pixels(&[], 64 * 48);
    let works = [1, 2].map(|edge| {
        let blocks = PilotBlocks { edge, film_size: (64, 48) };
        let measured = trace_pictures(&renderer, Some(&maps), &[], &no_images, &blocks);
        let PassWork { camera_work_per_pixel, photon_work_per_pixel, work_per_prefix_ray, work_per_lookup } =
            measured.pass_work(SAMPLES, &blocks, &photons, 4);
        [camera_work_per_pixel, photon_work_per_pixel, work_per_prefix_ray, work_per_lookup]
    });
    for (without, with) in works[0].into_iter().zip(works[1]) {
        assert!(without > 0.0 && (with / without - 1.0).abs() < 0.145, "{works:?}");
    }
}
