//! MuJoCo, in a Python process that replays whenever it gets a line.

use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use serde::Deserialize;

use crate::common::Recording;
use crate::{Contestant, Replay};

/// The Python that `just compare` prepares, from the crate's folder.
const PYTHON: &str = "../target/referee/bin/python";
const SCRIPT: &str = "referee/replay.py";

/// The process; it ends with its input.
pub(crate) struct MuJoCo {
    child: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// A replay: where the objects end, and how long MuJoCo's own loop took.
#[derive(Deserialize)]
struct Answer {
    ends: Vec<[f64; 3]>,
    seconds: f64,
}

impl MuJoCo {
    /// MuJoCo with one of the settings in the script; none where Python is not prepared.
    pub(crate) fn new(settings: &str, recordings: &[Recording]) -> Result<Option<Self>, Box<dyn Error>> {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let python = package.join(PYTHON);
        if !python.exists() {
            return Ok(None);
        }
        let mut child = Command::new(python)
            .args([package.join(SCRIPT).as_os_str(), settings.as_ref()])
            // Where it may leave a log.
            .current_dir(package.join("../target"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let questions = child.stdin.take();
        let answers = BufReader::new(child.stdout.take().ok_or("Python has no output")?);
        let mut mujoco = Self { child, questions, answers };
        mujoco.say(&serde_json::to_string(recordings)?)?;
        Ok(Some(mujoco))
    }

    fn say(&mut self, line: &str) -> Result<(), Box<dyn Error>> {
        Ok(writeln!(self.questions.as_mut().ok_or("Python has no input")?, "{line}")?)
    }
}

impl Contestant for MuJoCo {
    fn replay(&mut self) -> Result<Replay, Box<dyn Error>> {
        self.say("again")?;
        let mut line = String::new();
        self.answers.read_line(&mut line)?;
        let Answer { ends, seconds } = serde_json::from_str(&line)?;
        Ok(Replay { ends, time: Duration::from_secs_f64(seconds) })
    }
}

impl Drop for MuJoCo {
    fn drop(&mut self) {
        self.questions = None;
        let _ = self.child.wait();
    }
}
