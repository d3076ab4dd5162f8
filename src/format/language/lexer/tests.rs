use super::*;

#[test]
fn numbers_end_at_the_first_invalid_character() {
    for (text, float, integer) in [
        ("20}", "20", "20"),
        ("20width", "20", "20"),
        ("-.16 ", "-.16", ""),
        ("1.5.5", "1.5", "1"),
        ("+3.e-2x", "+3.e-2", "+3"),
        ("1e", "1", "1"),
        ("2e+", "2", "2"),
        ("7E5", "7E5", "7"),
        (".", "", ""),
        ("-", "", ""),
        ("e5", "", ""),
        ("nan", "", ""),
        ("-inf", "", ""),
    ] {
        assert_eq!(Lexer::new("", text).read_number_token().text, float, "{text}");
        assert_eq!(Lexer::new("", text).read_integer_token().text, integer, "{text}");
    }
}

#[test]
fn comments_start_only_where_a_token_could() {
    let mut lexer = Lexer::new("", "\u{feff} # one\r\n// two\n a//b#c# three");
    let token = lexer.peek_token();
    assert_eq!(token.text, "a//b#c#");
    lexer.consume_token(token);
    assert_eq!(lexer.peek_token().text, "three");
    assert!(Lexer::new("", "# end").peek_token().is_empty());
}

#[test]
fn names_may_hold_braces_and_spaces() {
    for (text, name) in [
        ("cube.obj}", "cube.obj"),
        ("wood{1}.bmp}", "wood{1}.bmp"),
        ("mesh/a#b//c.obj\r\n", "mesh/a#b//c.obj"),
        (r#""a \"b\" \\ c"}"#, r#"a "b" \ c"#),
        ("}", ""),
    ] {
        assert_eq!(Lexer::new("", text).read_name().unwrap().value, name, "{text}");
    }
    for text in ["\"open", "\"open\n\"", r#""C:\mesh.obj""#, "\"\\"] {
        assert!(Lexer::new("", text).read_name().is_err(), "{text}");
    }
}
