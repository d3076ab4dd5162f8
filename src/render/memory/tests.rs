use super::*;

#[test]
fn too_large_pictures_are_refused() {
    assert_eq!(check_picture_memory(1, (16_384, 16_384), None), Ok(88 << 28));
    assert!(matches!(check_picture_memory(1, (16_385, 16_384), None), Err(MemoryError::Pixels(_))));
    assert_eq!(check_picture_memory(1, (1000, 1000), Some(88_000_000)), Ok(88_000_000));
    let refused = check_picture_memory(1, (1000, 1000), Some(87_999_999)).unwrap_err().to_string();
    assert!(refused.contains("a picture of 1000 × 1000") && refused.contains("88.0 MB"), "{refused}");
    assert!(matches!(
        check_picture_and_error_memory(1, (1000, 1000), Some(469_999_999)),
        Err(MemoryError::Picture { .. })
    ));
    let layers = LayerSelection {
        estimates_error: true,
        groups_light: true,
        clamps_light: true,
        sends_to_tev: true,
        renders_aovs: true,
    };
    let bytes_per_pixel = 88 + 382 + 210 + 140 + 120 + 364;
    let check = |free| check_layered_picture_memory((1000, 1000), layers, Some(free));
    assert_eq!(check(bytes_per_pixel * 1_000_000), Ok(bytes_per_pixel * 1_000_000));
    assert!(matches!(check(bytes_per_pixel * 1_000_000 - 1), Err(MemoryError::Picture { .. })));
    assert_eq!(check_picture_memory(4, (500, 500), Some(88_000_000)), Ok(88_000_000));
    let refused = check_picture_memory(5, (500, 500), Some(88_000_000)).unwrap_err().to_string();
    assert!(refused.contains("5 pictures of 500 × 500 pixels take 110.0 MB"), "{refused}");
    let film =
        LayerSelection { estimates_error: true, groups_light: true, clamps_light: true, ..LayerSelection::default() };
    let check = |free| check_films_memory(2, (1000, 1000), film, Some(free));
    assert_eq!(check(2 * (88 + 382 + 210 + 140) * 1_000_000), Ok(()));
    let refused = check(2 * (88 + 382 + 210 + 140) * 1_000_000 - 1).unwrap_err().to_string();
    assert!(refused.contains("2 films at a time of 1000 × 1000 pixels take 1.6 GB"), "{refused}");
}

#[test]
fn too_many_photons_are_refused() {
    let index = u64::from(u32::MAX);
    let expected = |photons, largest_map| ExpectedPhotons {
        paths: 1,
        memory_in_photons: photons,
        largest_map_in_photons: largest_map,
    };
    assert_eq!(check_photon_memory(expected(2 * index, index), 0, None), Ok(()));
    assert!(matches!(check_photon_memory(expected(2 * index, index + 1), 0, None), Err(MemoryError::Indices { .. })));
    assert_eq!(check_photon_memory(expected(1000, 600), 0, Some(120_000)), Ok(()));
    assert_eq!(check_photon_memory(expected(1000, 600), 7, Some(120_007)), Ok(()));
    assert!(check_photon_memory(expected(1000, 600), 8, Some(120_007)).is_err());
    assert!(matches!(
        check_photon_memory(expected(1001, 600), 0, Some(120_000)),
        Err(MemoryError::Photons { stored: 1001, .. })
    ));
}
