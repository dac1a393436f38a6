//! What the program itself says. It is also what has Cargo build the program for the whole-system tests.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::process::{Command, Output};

const COMMANDS: [&str; 18] = [
    "run",
    "serve",
    "resume",
    "history",
    "show",
    "replay",
    "evaluate",
    "generalise",
    "compare",
    "transfer",
    "verify",
    "results",
    "report",
    "reproduce",
    "export",
    "digest",
    "completions",
    "man",
];

fn selftalk(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_selftalk")).args(words).output().unwrap()
}

#[test]
fn help_goes_to_stdout_and_lists_commands_and_exit_codes() {
    let output = selftalk(&["--help"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let help = String::from_utf8(output.stdout).unwrap();
    for word in ["--db", "--format", "Exit codes:", "130", "Examples:"].into_iter().chain(COMMANDS) {
        assert!(help.contains(word), "{word}: {help}");
    }
}

#[test]
fn every_command_explains_itself_with_examples() {
    for command in COMMANDS {
        let output = selftalk(&[command, "--help"]);
        let help = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && help.contains(&format!("selftalk {command}")), "{help}");
        assert!(help.contains("Examples:"), "{help}");
    }
}

#[test]
fn a_wrong_command_line_is_exit_code_2() {
    for words in [&[][..], &["evolve"], &["run"], &["run", "x", "--workers", "0"], &["history", "digest"]] {
        let output = selftalk(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{words:?}");
    }
}
