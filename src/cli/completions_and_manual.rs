//! `caustica completions` and `caustica man`: completion scripts and the manual page.

use super::{Arguments, CommandFailure, Exit};
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use std::io::{self, Write};

/// Prints the completion script of a shell.
pub(super) fn print_completions(shell: Shell) -> Result<Exit, CommandFailure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "caustica", &mut script);
    write_to_stdout(&script)
}

/// Prints the manual page in roff.
pub(super) fn print_manual() -> Result<Exit, CommandFailure> {
    let page = manual_page().map_err(CommandFailure::output_error)?;
    write_to_stdout(page.as_bytes())
}

/// Returns the manual page in roff, with a section for each subcommand at any depth.
fn manual_page() -> io::Result<String> {
    let mut command = Arguments::command();
    command.build();
    let mut page = render_roff(|out| Man::new(command.clone()).render(out))?;
    for subcommand in command.get_subcommands() {
        let name = subcommand.get_name();
        // Subcommands are sections of this page. Links to separate pages of subcommands would be
        // dead.
        page = page.replace(&format!("caustica\\-{name}(1)"), &format!("caustica {name}"));
    }
    push_subcommand_sections(&mut page, &command, "CAUSTICA")?;
    Ok(page)
}

/// Appends a section for each subcommand of `command`, and for their subcommands, to `page`.
/// `title` is the title of the section of `command`.
fn push_subcommand_sections(page: &mut String, command: &Command, title: &str) -> io::Result<()> {
    for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
        let title = format!("{title} {}", subcommand.get_name().to_uppercase());
        *page += &format!(".SH \"{title}\"\n{}", subcommand_section(subcommand)?);
        push_subcommand_sections(page, subcommand, &title)?;
    }
    Ok(())
}

/// Returns the synopsis, description and options of a subcommand as roff subsections.
fn subcommand_section(subcommand: &Command) -> io::Result<String> {
    let man = Man::new(subcommand.clone());
    let text = render_roff(|out| {
        man.render_synopsis_section(out)?;
        man.render_description_section(out)?;
        man.render_options_section(out)
    })?;
    Ok(text.replace(".SH ", ".SS "))
}

/// Returns the text that the callback `render` writes.
fn render_roff(render: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> io::Result<String> {
    let mut text = Vec::new();
    render(&mut text)?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn write_to_stdout(text: &[u8]) -> Result<Exit, CommandFailure> {
    io::stdout().write_all(text).map_err(CommandFailure::output_error)?;
    Ok(Exit::Success)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manual_has_flags_of_nested_subcommands() {
        let page = manual_page().unwrap();
        let (_, slurm) = page.split_once(".SH \"CAUSTICA FARM SLURM\"").unwrap();
        let (section, _) = slurm.split_once(".SH ").unwrap();
        assert!(section.contains("caustica farm slurm") && section.contains("\\-\\-poll"), "{section}");
        assert!(!page.contains(".SH \"CAUSTICA FARM HELP\""));
    }
}
