//! Text of CSV rows and Markdown elements for study reports.

/// Returns a row of comma-separated values with its line end (RFC 4180). Quotes cells if necessary.
pub(super) fn csv_row<T: AsRef<str>>(cells: &[T]) -> String {
    let quoted = |cell: &T| {
        let cell = cell.as_ref();
        if cell.contains(['"', ',', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.to_owned()
        }
    };
    cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\r\n"
}

/// Returns a Markdown table with the head row `heads`; escapes all cells.
pub(super) fn markdown_table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut table = line(heads.iter().map(|head| escape_markdown(head)).collect());
    table += &format!("|{}\n", " --- |".repeat(heads.len()));
    rows.iter().for_each(|row| table += &line(row.iter().map(|cell| escape_markdown(cell)).collect()));
    table
}

/// Escapes Markdown markup in `text`.
pub(super) fn escape_markdown(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '|' | '*' | '_' | '`' | '<' | '[' | ']' | '#' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// Returns a Markdown code block with the shell command `text`. Its fence is longer than any run of
/// backticks in `text`.
pub(super) fn markdown_code_block(text: &str) -> String {
    let mut longest = 2;
    let mut run = 0;
    for c in text.chars() {
        run = if c == '`' { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let fence = "`".repeat(longest + 1);
    format!("{fence}sh\n{text}\n{fence}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_rows_quote_separators() {
        assert_eq!(csv_row(&["a", "b, \"c\"", "d\ne"]), "a,\"b, \"\"c\"\"\",\"d\ne\"\r\n");
    }

    #[test]
    fn markdown_markup_is_escaped() {
        let table = markdown_table(&["a|b", "c"], &[vec!["x_y".into(), "1 %".into()]]);
        assert_eq!(table, "| a\\|b | c |\n| --- | --- |\n| x\\_y | 1 % |\n");
        assert_eq!(markdown_code_block("echo ```"), "````sh\necho ```\n````\n");
    }
}
