//! What the program itself says. It is also what has Cargo build the program for the whole-system tests.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::process::{Command, Output};

fn worker(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_selftalk-worker")).args(words).output().unwrap()
}

#[test]
fn help_goes_to_stdout_and_lists_exit_codes() {
    let output = worker(&["--help"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let help = String::from_utf8(output.stdout).unwrap();
    for word in ["--master", "--slots", "--connect-timeout", "Exit codes:", "130", "Examples:"] {
        assert!(help.contains(word), "{word}: {help}");
    }
}

#[test]
fn a_wrong_command_line_is_exit_code_2() {
    let lines =
        [&["--slots", "0"][..], &["--master", "node1:7700"], &["--master", "https://a:1"], &["--master", ""]];
    for words in lines {
        let output = worker(words);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {stderr}");
        assert_eq!(
            stderr.lines().filter(|line| line.starts_with("error: ")).count(),
            1,
            "{words:?}: {stderr}"
        );
        assert!(output.stdout.is_empty(), "{words:?}");
    }
}
