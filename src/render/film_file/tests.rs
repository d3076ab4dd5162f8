use super::*;
use crate::integrate::SilentMonitor;
use crate::render::test_integrator::{NoisyIntegrator, SIZE};
use crate::render::{StopCriteria, render};
use std::sync::atomic::AtomicBool;

fn header() -> FilmHeader {
    FilmHeader {
        program_version: "1.2.3".to_owned(),
        scene: "a/ring.txt".to_owned(),
        inputs: vec![InputDigest { name: "ring.txt".to_owned(), digest: "12ab".to_owned() }],
        width: SIZE.0,
        height: SIZE.1,
        settings: vec!["--spp".to_owned(), "4".to_owned()],
        seed: 7,
        planned_passes: Some(12),
    }
}

fn rendered(passes: std::ops::Range<u32>) -> RenderResult {
    let integrator = NoisyIntegrator { sigma: 0.3, bias: 0.1, estimates_error: true };
    let interrupted = AtomicBool::new(false);
    let stop = StopCriteria::unlimited(&interrupted);
    let before = RenderResult::without_passes(&integrator, SIZE);
    render(before, passes, &integrator, &stop, &SilentMonitor, |_| {})
}

fn bytes(rendered: &RenderResult) -> Vec<u8> {
    let mut bytes = Vec::new();
    FilmFile::write(&header(), rendered, &mut bytes).unwrap();
    bytes
}

#[test]
fn films_are_read_as_they_were_written() {
    let rendered = rendered(3..9);
    let film = FilmFile::read(&bytes(&rendered)[..]).unwrap();
    assert_eq!(film.header, header());
    assert_eq!(film.rendered.film, rendered.film);
    assert_eq!(film.rendered.pass_numbers, rendered.pass_numbers);
    assert_eq!(read_pass_numbers(&bytes(&rendered)[..]).unwrap(), rendered.pass_numbers);
    assert_eq!(film.rendered.counters, rendered.counters);
    let [read, written] = [&film.rendered, &rendered].map(|rendered| {
        let estimator = rendered.estimator.as_ref().unwrap();
        (format!("{:?}", estimator.estimate(&rendered.film)), estimator.error_maps(&rendered.film).noise)
    });
    assert_eq!(read, written);
    assert_eq!(film.header.missing_passes(&film.rendered.pass_numbers).to_string(), "1–3, 10–12");
}

/// Any byte with one flipped bit, and any shorter file, is refused.
#[test]
fn damaged_films_are_refused() {
    let whole = bytes(&rendered(0..5));
    for at in (0..whole.len()).filter(|at| *at < 2000 || at % 97 == 0) {
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(FilmFile::read(&flipped[..]).is_err(), "byte {at}");
        let cut = FilmFile::read(&whole[..at]);
        assert!(matches!(cut, Err(FilmFileError::NoFilm | FilmFileError::CutOff)), "cut at {at}: {cut:?}");
    }
}

/// Sums with valid checksums that contradict each other are refused.
#[test]
fn inconsistent_films_are_refused() {
    let refused = |rendered: &RenderResult| FilmFile::read(&bytes(rendered)[..]).is_err();
    assert!(!refused(&rendered(0..5)));
    let mut other_passes = rendered(0..5);
    other_passes.pass_numbers.insert(7..8);
    assert!(refused(&other_passes));
    let mut other_estimator = rendered(0..5);
    other_estimator.estimator = rendered(0..6).estimator;
    assert!(refused(&other_estimator));
    let mut other_size = rendered(0..5);
    other_size.film = crate::render::Film::new(3, 3);
    assert!(refused(&other_size));
}

#[test]
fn differences_of_headers_are_named() {
    assert!(header().differences(&FilmHeader { scene: "b.txt".to_owned(), ..header() }).is_empty());
    let digest = |digest: &str| vec![InputDigest { digest: digest.to_owned(), ..header().inputs[0].clone() }];
    let other = FilmHeader { seed: 8, settings: Vec::new(), width: 9, inputs: digest("34cd"), ..header() };
    let lines = header().differences(&other);
    assert_eq!(
        lines,
        [
            "size: 40x40 here, 9x40 there",
            "seed: 7 here, 8 there",
            "settings: `--spp 4` here, the default there",
            "file `ring.txt` has another content or is new",
        ]
    );
}

/// Files of equal names, which can come from outside the scene's folder, are compared one by one.
#[test]
fn files_of_equal_names_are_compared_one_by_one() {
    let input = |name: &str, digest: &str| InputDigest { name: name.to_owned(), digest: digest.to_owned() };
    let header = |inputs: &[InputDigest]| FilmHeader { inputs: inputs.to_vec(), ..header() };
    let (one, two) = (input("wood.png", "12ab"), input("wood.png", "34cd"));
    let (first, both) = (header(std::slice::from_ref(&one)), header(&[one.clone(), two.clone()]));
    assert_eq!(first.differences(&both), ["file `wood.png` is missing here"]);
    assert_eq!(both.differences(&first), ["file `wood.png` has another content or is new"]);
    assert_eq!(header(&[one]).differences(&header(&[two])), ["file `wood.png` has another content or is new"]);
}

/// Films of two parts add up to the film of the whole, in both orders; common passes are refused.
#[test]
fn merged_films_have_the_bits_of_one_render() {
    let whole = rendered(0..9);
    for (first, second) in [(0..4, 4..9), (4..9, 0..4), (2..3, 0..2)] {
        let end = first.end.max(second.end);
        let mut sum = rendered(first.clone());
        sum.merge(&rendered(second)).unwrap();
        if end == 9 {
            assert_eq!(sum.film, whole.film);
            let estimate = |rendered: &RenderResult| {
                format!("{:?}", rendered.estimator.as_ref().unwrap().estimate(&rendered.film))
            };
            assert_eq!(estimate(&sum), estimate(&whole));
        }
        let error = sum.merge(&rendered(first)).unwrap_err();
        assert!(error.to_string().starts_with("both renders have passes"), "{error}");
    }
}
