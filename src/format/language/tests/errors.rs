//! Syntax errors: suggestions, limits of nesting, and recovery after an error.

use super::*;

#[test]
fn unknown_words_get_a_suggestion() {
    assert_first_error("Group { ‹Spere› { } }", "unexpected `Spere` in `Group`", "did you mean `Sphere`?");
    assert_first_error("Group { Sphere { ‹radios› 1 } }", "unexpected `radios` in `Sphere`", "did you mean `radius`?");
    assert_first_error("‹Light› { }", "unexpected `Light` in the file", "did you mean `Lights`?");
    assert_first_error("Lights { ‹pointLight› { } }", "unexpected `pointLight`", "did you mean `PointLight`?");
    assert_first_error("Materials { ‹Glass› { } }", "unexpected `Glass`", "write `Dielectric`");
    assert_first_error("Group { Sphere { center 0 0 0\n‹Plane› {", "unexpected `Plane`", "is a `}` missing before it?");
    assert_first_error("Group { } ‹}›", "unexpected `}` in the file", "closes nothing");
    assert_first_error("Group ‹Sphere›", "expected `{` in `Group`, found `Sphere`", "put `{` before it");
    let long = "x".repeat(1000);
    let error = parse_with_camera(&format!("Group {{ {long}\u{1b}[31m }}")).unwrap_err();
    assert!(error.message().len() < 100 && !error.message().contains('\u{1b}'));
}

#[test]
fn an_unclosed_block_is_reported_where_it_opens() {
    for body in [
        "‹Group› {",
        "Group { ‹Sphere›",
        "Group { ‹Sphere› { center 0 0",
        "Group { ‹Sphere› { center 0 0 0 radius",
        "Group { ‹TriangleMesh› { obj_file",
        "Group { Transform { ‹Matrix› { 1 2",
        "Group { RevSurface { profile ‹BezierCurve› { controls [ 1 2 3",
        "Materials { ‹Mirror›",
    ] {
        assert_first_error(body, "the file ends inside", "close it with `}`");
    }
    assert_error(parse("a", ""), (1, 1), "", "the file has no camera", "add `PerspectiveCamera {");
    assert_error(parse_with_camera(""), (1, 1), "", "the file has no Group", "add `Group { … }`");
}

#[test]
fn nesting_is_limited() {
    let nested = |n: usize, open: &str| format!("{}{}", open.repeat(n), "}".repeat(n));
    let deepest = parse_with_camera(&nested(MAX_NESTING_DEPTH, "Group { numObjects 1 ").replace("1 }", "0 }")).unwrap();
    assert_eq!(parse("again", &deepest.to_string()).unwrap(), deepest);
    for n in [MAX_NESTING_DEPTH + 1, 10_000, 1_000_000] {
        for open in ["Group { numObjects 1\n", "Group {\n", "Group { Transform {\n"] {
            let error = parse_with_camera(&nested(n, open)).unwrap_err();
            assert!(error.message().contains("nest more than 512 deep"), "{error}");
            assert!(error.remedy().contains("side by side"));
        }
        let error = parse_with_camera(&"Group { numObjects 1\n".repeat(n)).unwrap_err();
        assert_eq!((error.line(), error.column(), error.offending_text()), (2 + MAX_NESTING_DEPTH, 1, "Group"));
    }
}

#[test]
fn objects_side_by_side_are_unlimited() {
    let body = "Group { } Transform { Group { } }".repeat(2 * MAX_NESTING_DEPTH);
    assert_eq!(parse_with_camera(&format!("Group {{ {body} }}")).unwrap().root.items.len(), 4 * MAX_NESTING_DEPTH);
}

#[test]
fn the_deepest_nesting_fits_a_small_stack() {
    let run = || {
        let open = "Group { Transform { Scale 1 1 1 ".repeat(MAX_NESTING_DEPTH / 2);
        let d = parse_with_camera(&format!(
            "{open} Sphere {{ center 0 0 0 radius 1 }} {}",
            "}}".repeat(MAX_NESTING_DEPTH / 2)
        ))
        .unwrap();
        let copy = d.clone();
        assert!(copy == d && parse("again", &copy.to_string()).unwrap() == d && !format!("{d:?}").is_empty());
    };
    // Half of the default stack of a Rust thread.
    std::thread::Builder::new().stack_size(1 << 20).spawn(run).unwrap().join().unwrap();
}

#[test]
fn bytes_that_are_not_utf8_are_refused() {
    assert!(parse_scene_bytes("a", format!("{CAMERA} Group {{}}").as_bytes()).is_ok());
    let error = parse_scene_bytes("a", b"# ok\n  \xff Group").unwrap_err();
    assert_eq!((error.line(), error.column()), (2, 3));
    assert!(error.message().contains("byte 0xff at offset 7") && error.remedy().contains("save the file as UTF-8"));
    assert!(parse_scene_bytes("a", b"\xff\xfeP\0").unwrap_err().remedy().contains("UTF-16"));
}

/// Parses `CAMERA` followed by `body`. Returns the line and the marked text of each error.
fn error_positions(body: &str) -> Vec<(usize, String)> {
    let error = parse_with_camera(body).unwrap_err();
    std::iter::once(&error).chain(error.further_errors()).map(|e| (e.line(), e.offending_text().to_owned())).collect()
}

#[test]
fn all_errors_of_a_file_are_reported() {
    let body = "Lights { PointLight { position 0 0 0 }
        SpherLight { center 0 0 0 }
        SphereLight { radius -1 center 0 0 power 1 1 1 } }
        Materials { Diffuse red { reflectance 2 0 0 } Mirror m { } }
        Group { MaterialName red Sphere { radius x center 0 0 0 }
        Group { Transform { Scale 0 1 1 Sphere { center 0 0 0 radius 1 } } Disc { } }
        MaterialName blue }
        Camera { }";
    let expected = [
        (2, "PointLight"),
        (3, "SpherLight"),
        (4, "-1"),
        (4, "power"),
        (5, "2 0 0"),
        (6, "x"),
        (7, "0 1 1"),
        (7, "Disc"),
        (8, "blue"),
        (9, "Camera"),
    ];
    assert_eq!(error_positions(body), expected.map(|(line, text)| (line, text.to_owned())));
}

#[test]
fn one_missing_brace_is_one_error() {
    let errors =
        error_positions("Group {\n Sphere { center 0 0 0 radius 1\n Disc { }\n Sphere { center 0 0 0 radius 1 } }");
    assert_eq!(errors, [(4, "Disc".to_owned()), (4, "Disc".to_owned())]);
    assert_eq!(error_positions("Group { Sphere { center 0 0 0 radius 1 ").len(), 1);
    assert_eq!(error_positions("Group { Sphere { center 0 0 radius 1").len(), 1);
}

#[test]
fn at_most_twenty_errors_are_reported() {
    assert_eq!(error_positions(&format!("Group {{ {} }}", "Spere { } ".repeat(50))).len(), 20);
}

#[test]
fn keywords_of_other_renderers_get_a_suggestion() {
    assert_first_error("Lights { ‹SunLight› { } }", "unexpected `SunLight`", "write `DirectionalLight`");
    assert_first_error("Lights { ‹DistantLight› { } }", "unexpected `DistantLight`", "write `DirectionalLight`");
    assert_first_error("Materials { Dielectric { ‹ior› 1.5 } }", "unexpected `ior`", "write `indexOfRefraction`");
    assert_first_error("Materials { Diffuse { ‹albedo› 1 1 1 } }", "unexpected `albedo`", "write `reflectance`");
}
