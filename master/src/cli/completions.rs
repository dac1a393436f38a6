//! `selftalk completions`: what a shell has to know to complete command lines.

use clap::CommandFactory;

use super::args::CompletionsArgs;
use super::{Cli, output};
use crate::exit::Failure;

/// Carries out the command.
///
/// # Errors
/// Those of printing.
pub fn run(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "selftalk", &mut text);
    output::print_text(&text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;
    use clap_complete::Shell;

    #[test]
    fn every_shell_knows_every_command() {
        for shell in Shell::value_variants() {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "selftalk", &mut text);
            let text = String::from_utf8(text).unwrap();
            for command in Cli::command().get_subcommands() {
                assert!(text.contains(command.get_name()), "{shell}: {}", command.get_name());
            }
        }
    }
}
