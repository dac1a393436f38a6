//! How the program fits into a shell: its colours, its logs, completions and manual pages.

use std::ffi::OsString;
use std::io::IsTerminal;
use std::path::PathBuf;

use clap::{Args, ColorChoice, ValueEnum};
use clap_complete::Shell;

/// How logs are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum LogFormat {
    /// Lines for people
    #[default]
    Text,
    /// A JSON object a line
    Json,
}

/// Whether there are colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Color {
    /// On a terminal, unless the environment has NO_COLOR
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

impl Color {
    /// What a command line asks for, before it is parsed: help and its errors have colours too.
    #[must_use]
    pub fn asked(words: impl IntoIterator<Item = OsString>) -> Self {
        let words: Vec<String> = words.into_iter().filter_map(|word| word.into_string().ok()).collect();
        let values = words.iter().enumerate().filter_map(|(at, word)| match word.strip_prefix("--color") {
            Some("") => words.get(at + 1).map(String::as_str),
            Some(rest) => rest.strip_prefix('='),
            None => None,
        });
        values.filter_map(|value| Self::from_str(value, false).ok()).next_back().unwrap_or_default()
    }

    /// The same for the parser.
    #[must_use]
    pub const fn choice(self) -> ColorChoice {
        match self {
            Self::Auto => ColorChoice::Auto,
            Self::Always => ColorChoice::Always,
            Self::Never => ColorChoice::Never,
        }
    }

    /// Whether logs have colours.
    #[must_use]
    pub fn on_stderr(self) -> bool {
        match self {
            Self::Auto => {
                let forbidden = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
                !forbidden && std::io::stderr().is_terminal()
            }
            Self::Always => true,
            Self::Never => false,
        }
    }
}

/// Arguments of `selftalk completions`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk completions bash > ~/.local/share/bash-completion/completions/selftalk
  selftalk completions zsh > ~/.zfunc/_selftalk
  selftalk completions fish > ~/.config/fish/completions/selftalk.fish

`selftalk --help` lists the exit codes.")]
pub struct CompletionsArgs {
    /// For which shell
    #[arg(value_enum, value_name = "SHELL")]
    pub shell: Shell,
}

/// Arguments of `selftalk man`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk man | man -l -                       read it
  selftalk man --out ~/.local/share/man/man1    a page for each command, which `man selftalk-run` finds

`selftalk --help` lists the exit codes.")]
pub struct ManArgs {
    /// Write a page for each command into this folder [default: the page of selftalk, to stdout]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_known_before_the_command_line_is() {
        let asked = |words: &str| Color::asked(words.split(' ').map(OsString::from));
        assert_eq!(asked("selftalk --color never --help"), Color::Never);
        assert_eq!(asked("selftalk run --color=always x --nonsense"), Color::Always);
        assert_eq!(asked("selftalk --color=never --color auto"), Color::Auto);
        assert_eq!(asked("selftalk --color green"), Color::Auto);
        assert_eq!(asked("selftalk --colors never"), Color::Auto);
    }
}
