//! `caustica completions` and `caustica man`: files for shells and for `man`.

use super::{Arguments, Exit, Failure};
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::Write;

/// Prints the completion script of a shell.
pub(super) fn completions(shell: Shell) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "caustica", &mut script);
    print(&script)
}

/// Prints the manual page in roff: one page with a section for each subcommand.
pub(super) fn man() -> Result<Exit, Failure> {
    let mut command = Arguments::command();
    command.build();
    let mut page = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut page).map_err(Failure::output)?;
    for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
        let man = clap_mangen::Man::new(subcommand.clone());
        let name = subcommand.get_display_name().unwrap_or_else(|| subcommand.get_name()).replace('-', " ");
        page.extend(format!(".SH \"{}\"\n", name.to_uppercase()).bytes());
        man.render_description_section(&mut page).map_err(Failure::output)?;
        man.render_options_section(&mut page).map_err(Failure::output)?;
    }
    print(&page)
}

fn print(text: &[u8]) -> Result<Exit, Failure> {
    std::io::stdout().write_all(text).map_err(Failure::output)?;
    Ok(Exit::Success)
}
