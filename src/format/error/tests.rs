use super::*;

fn error_report_text(error: &SceneError) -> String {
    let mut text = String::new();
    let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor());
    handler.render_report(&mut text, error).unwrap();
    text
}

fn make_error_at_span(text: &str, start: usize, len: usize) -> SceneError {
    SceneError::error_at_span(
        &SourceText::new("a.txt", text),
        Span { start, len },
        "no such word",
        "here",
        "write `right`",
    )
}

#[test]
fn reports_show_position_text_and_remedy() {
    let error = make_error_at_span("one\r\n  über wrong\r\nthree", 13, 5);
    assert_eq!((error.line(), error.column(), error.offending_text()), (2, 8, "wrong"));
    assert_eq!(error.to_string(), "a.txt:2:8: no such word");
    let report = error_report_text(&error);
    for part in ["a.txt:2:8", "no such word", "über wrong", "here", "write `right`"] {
        assert!(report.contains(part), "{part} is not in\n{report}");
    }
}

#[test]
fn long_lines_are_truncated() {
    let error = make_error_at_span(&"word ".repeat(100_000), 200_000, 100_000);
    assert_eq!(error.column(), 200_001);
    let report = error_report_text(&error);
    assert!(report.len() < 3000 && report.contains("a.txt:1:200001"), "{report}");
}

#[test]
fn any_span_can_be_reported() {
    for text in ["", "\n", "ü", "a\r\nb"] {
        for (start, len) in [(0, 0), (0, 9), (1, 1), (9, 9), (usize::MAX, usize::MAX)] {
            assert!(error_report_text(&make_error_at_span(text, start, len)).contains("write `right`"));
        }
    }
    let file = SceneError::error_for_whole_file(&SourceText::new("a.txt", ""), "nothing here", "write something");
    assert!(
        error_report_text(&file).contains("a.txt:1:1: nothing here")
            && error_report_text(&file).contains("write something")
    );
}

#[test]
fn control_characters_are_escaped() {
    let error = make_error_at_span("one \u{1b}[31m wrong\u{7}", 10, 6);
    let report = error_report_text(&error);
    assert!(!report.contains(['\u{1b}', '\u{7}']), "{report:?}");
    assert!(report.contains("\\u{1b}[31m wrong\\u{7}") && report.contains("a.txt:1:11"), "{report}");
}

#[test]
fn several_errors_are_reported_in_order() {
    let errors = [make_error_at_span("one two", 4, 3), make_error_at_span("one two", 0, 3)].to_vec();
    let joined = SceneError::from_errors(errors).unwrap();
    assert_eq!(
        (joined.offending_text(), joined.further_errors().len(), joined.further_errors()[0].offending_text()),
        ("one", 1, "two")
    );
    let report = error_report_text(&joined);
    assert!(report.contains("a.txt:1:1:") && report.contains("a.txt:1:5"), "{report}");
    assert!(SceneError::from_errors(Vec::new()).is_none());
}

#[test]
fn errors_may_lack_a_position() {
    let error = SceneError::error_without_position("a.glb", "no such node", "export it again");
    assert_eq!(error.to_string(), "a.glb: no such node");
    assert!(error_report_text(&error).contains("export it again"));
}
