//! Tests of splats: light that photons add directly to the film.

use super::*;
use crate::camera::FilterKind;
use glam::Vec2;

const SIZE: (u32, u32) = (12, 8);

fn splat_image(splats: &[Splat], filter: &Filter) -> Vec<DVec3> {
    let mut image = vec![Rgb::ZERO; (SIZE.0 * SIZE.1) as usize];
    add_splats(splats.to_vec(), filter, SIZE.0, &mut image);
    image.into_iter().map(|v| v.as_dvec3()).collect()
}

fn splat_at(x: f32, y: f32) -> Splat {
    Splat { film_position: Vec2::new(x, y), integrated_radiance: Rgb::new(1.0, 2.0, 3.0) }
}

/// A splat adds all its light to the image: the filter weights of its pixels sum to 1.
///
/// The sum is exact for the box filter, and correct on average over splat positions for other
/// filters.
#[test]
fn splats_conserve_light() {
    for kind in [FilterKind::Box, FilterKind::Tent, FilterKind::BlackmanHarris, FilterKind::Mitchell] {
        let filter = Filter::new(kind);
        let splats: Vec<Splat> = (0..100u16)
            .map(|i| splat_at(4.0 + (f32::from(i % 10) + 0.5) / 10.0, 4.0 + (f32::from(i / 10) + 0.5) / 10.0))
            .collect();
        let sum = splat_image(&splats, &filter).into_iter().sum::<DVec3>() / 100.0;
        assert!((sum - DVec3::new(1.0, 2.0, 3.0)).length() < 2e-3, "{kind:?}: {sum}");
    }
    let image = splat_image(&[splat_at(3.2, 5.9)], &Filter::new(FilterKind::Box));
    assert_eq!(image[5 * 12 + 3], DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(image.iter().filter(|v| **v != DVec3::ZERO).count(), 1);
}

/// Splats at or far beyond the edge of the film change only pixels of the film.
#[test]
fn splats_outside_the_film_are_clipped() {
    let filter = Filter::new(FilterKind::BlackmanHarris);
    for (x, y) in [(-0.4, 3.0), (12.4, 3.0), (5.0, -0.9), (5.0, 8.9), (-1e9, 3.0), (5.0, 1e9), (-50.0, -50.0)] {
        let sum = splat_image(&[splat_at(x, y)], &filter).into_iter().sum::<DVec3>().x;
        let near = x > -2.0 && x < 14.0 && y > -2.0 && y < 10.0;
        assert!(if near { sum > 0.0 && sum < 0.9 } else { sum == 0.0 }, "{x} {y}: {sum}");
    }
}

/// Filter weights of a splat sum to the same value in the middle of a panorama and at its seam,
/// poles and corners.
#[test]
fn panorama_splats_keep_their_light_at_seam_and_poles() {
    let camera = Camera::panorama(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, SIZE.0, SIZE.1).unwrap();
    for kind in [FilterKind::Box, FilterKind::Tent, FilterKind::BlackmanHarris, FilterKind::Mitchell] {
        let filter = Filter::new(kind);
        let sum_at = |x: f32, y: f32| {
            let mut splats = vec![splat_at(x, y)];
            add_splats_across_seams(&mut splats, &camera, &filter);
            splat_image(&splats, &filter).into_iter().sum::<DVec3>()
        };
        let middle = sum_at(5.25, 4.375);
        let at_edges = [(0.25, 4.375), (11.25, 4.375), (3.25, 0.375), (3.25, 7.375), (0.25, 0.375), (11.25, 7.375)];
        for (x, y) in at_edges {
            assert!((sum_at(x, y) - middle).length() < 1e-5, "{kind:?} at {x}, {y}");
        }
    }
}
