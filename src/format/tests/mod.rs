//! Tests of the scene language: examples of its reference, canonical form, random descriptions.

mod strategies;
mod variants;

use proptest::collection::vec;
use proptest::prelude::*;

use super::parse;
use strategies::random_description;

#[test]
fn examples_of_the_reference_parse_and_print_back() {
    let page = include_str!("../../../docs/guide/scene-language.md");
    let scenes: Vec<&str> = page.split("```caustica\n").skip(1).filter_map(|part| part.split("```").next()).collect();
    assert!(scenes.len() >= 8);
    for text in scenes {
        let d = parse("scene-language.md", text).unwrap();
        assert_eq!(parse("again", &d.to_string()).unwrap(), d);
    }
    assert!(page.contains(&crate::bsdf::METAL_NAMES.join(", ")), "the page lists other metals");
    let glasses = crate::color::GLASSES.map(|g| g.0).join(", ");
    assert!(page.contains(&glasses), "the page lists other glasses than {glasses}");
}

#[test]
fn the_reference_tables_match_the_program() {
    let page = include_str!("../../../docs/guide/scene-language.md");
    assert!(super::update_reference_tables(page) == page, "run `cargo run --example scene_language`");
    assert_eq!(page.matches("<!-- reference: ").count(), 7);
}

#[test]
fn descriptions_print_in_canonical_form() {
    let text = "Group{MaterialName\"a b\"Transform{Rotate{0 0 1 90}Sphere{radius 1e-7center 1 -0.5 1e20}}}";
    let camera = "PerspectiveCamera{lookAt 0 0 0center 0 0 1angle 9}Materials{Mirror\"a b\"{}}";
    let expected = "\
PerspectiveCamera {
    center 0 0 1
    lookAt 0 0 0
    up 0 1 0
    angle 9
    width 960
    height 720
}
Background {
    color 0.5 0.5 0.5
}
Materials {
    numMaterials 1
    Mirror \"a b\" {
        reflectance 1 1 1
    }
}
Group {
    numObjects 1
    MaterialName \"a b\"
    Transform {
        Rotate { 0 0 1 90 }
        Sphere {
            center 1 -0.5 1e20
            radius 1e-7
        }
    }
}
";
    assert_eq!(parse("a", &format!("{camera}{text}")).unwrap().to_string(), expected);
}

#[test]
fn parsing_takes_linear_time() {
    let time = |n: usize| {
        let body = "Sphere { center 0 0 0 radius 1 }\n".repeat(n);
        let text =
            format!("PerspectiveCamera {{ center 0 0 0 direction 0 0 1 angle 9 }} Group {{ numObjects {n} {body} }}");
        let start = std::time::Instant::now();
        assert_eq!(parse("a", &text).unwrap().root.items.len(), n);
        start.elapsed().as_secs_f64()
    };
    // 40 times the text takes 40 times as long if time is linear, 1600 times if it is quadratic.
    // The bound between them leaves room for noise from other processes.
    let least = |n: usize| (0..4).map(|_| time(n)).fold(f64::INFINITY, f64::min);
    let (small, large) = (least(2_000), least(80_000));
    assert!(large < 400.0 * small, "{small} s, then {large} s");
}

/// Returns random text made of words of the language and other characters.
fn random_scene_like_text() -> impl Strategy<Value = String> {
    let words =
        include_str!("../../../docs/guide/scene-language.md").split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let word = prop_oneof![
        4 => proptest::sample::select(words),
        2 => proptest::sample::select(vec!["{", "}", "[", "]", "\"", "\\", "0", "1", "-", ".", "1e", "#", "\n"])
            .prop_map(str::to_owned),
        1 => ".{0,4}",
    ];
    (vec(word, 0..80), prop_oneof![Just(""), Just(" ")]).prop_map(|(words, gap)| words.join(gap))
}

proptest! {
    #[test]
    fn printed_descriptions_parse_back_unchanged(d in random_description()) {
        let text = d.to_string();
        match parse("printed", &text) {
            Ok(again) => prop_assert_eq!(again, d),
            Err(error) => prop_assert!(false, "{:?}\n{}", miette::Report::new(error), text),
        }
    }

    #[test]
    fn random_scene_like_text_never_panics(soup in random_scene_like_text(), start in 0..3_usize) {
        let start = ["", "Group {", "PerspectiveCamera { center 0 0 0 direction 0 0 1 angle 9 } Group {"][start];
        if let Err(error) = parse("soup", &format!("{start}{soup}")) {
            prop_assert!(!error.remedy().is_empty());
            let report = format!("{:?}", miette::Report::new(error));
            prop_assert!(!report.is_empty());
        }
    }

    #[test]
    fn random_bytes_never_panic(bytes in vec(any::<u8>(), 0..200)) {
        if let Err(error) = super::parse_scene_bytes("bytes", &bytes) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn cut_or_changed_scenes_never_panic(d in random_description(), at in any::<prop::sample::Index>(), new in ".{0,2}") {
        let text = d.to_string();
        let cut = text.floor_char_boundary(at.index(text.len()));
        let _ = parse("cut", &text[..cut]);
        let after = text[cut..].chars().next().map_or(cut, |c| cut + c.len_utf8());
        let _ = parse("changed", &format!("{}{new}{}", &text[..cut], &text[after..]));
    }
}
