//! Talks to MuJoCo, which is in a Python process of its own: a line of JSON asks, a line of JSON answers.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The Python that `just referee` prepares, from the root of the repository.
const PYTHON: &str = "target/referee/bin/python";

/// The process; it ends with its input.
pub(super) struct Python {
    child: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Python {
    pub(super) fn start() -> Self {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let python = package.join("..").join(PYTHON);
        assert!(python.exists(), "there is no {PYTHON}: `just referee` prepares it");
        let mut child = Command::new(python)
            .arg(package.join("referee/referee.py"))
            // Where it may leave a log.
            .current_dir(package.join("../target"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let questions = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().unwrap());
        Self { child, questions, answers }
    }

    pub(super) fn ask<Answer: DeserializeOwned>(
        &mut self,
        question: &str,
        arguments: &impl Serialize,
    ) -> Answer {
        let mut line = serde_json::to_string(&(question, arguments)).unwrap();
        line.push('\n');
        self.questions.as_mut().unwrap().write_all(line.as_bytes()).unwrap();
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        assert!(!answer.is_empty(), "{question}: no answer; what Python said stands above");
        serde_json::from_str(&answer).unwrap()
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        self.questions = None;
        let _ = self.child.wait();
    }
}
