//! What a command came to.

use std::process::{ExitStatus, Output};

use serde_json::Value;

/// What a command came to.
#[derive(Debug)]
pub struct Outcome {
    /// The exit code; none if it was killed.
    pub code: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it reported.
    pub stderr: String,
}

impl Outcome {
    pub(crate) fn new(status: ExitStatus, stdout: String, stderr: String) -> Self {
        Self { code: status.code(), stdout, stderr }
    }

    /// Makes sure that it succeeded.
    ///
    /// # Panics
    /// If it did not.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        assert!(self.stderr.lines().all(|line| !line.starts_with("error: ")), "{self:?}");
        self
    }

    /// Makes sure that it ended with this exit code and one line that says why, the last on stderr, and returns that
    /// line without the `error: `.
    ///
    /// # Panics
    /// If it did not.
    #[track_caller]
    pub fn failed(self, code: i32) -> String {
        assert_eq!(self.code, Some(code), "{self:?}");
        let is_error = |line: &&str| line.starts_with("error: ");
        assert_eq!(self.stderr.lines().filter(is_error).count(), 1, "{self:?}");
        assert!(!self.stderr.contains("panicked"), "{self:?}");
        let last = self.stderr.lines().last().and_then(|line| line.strip_prefix("error: "));
        last.unwrap_or_else(|| panic!("{self:?}")).to_owned()
    }

    /// The same for a command that fails before it does anything: nothing else is on stderr, and nothing on stdout.
    ///
    /// # Panics
    /// If it did not.
    #[track_caller]
    pub fn refused(self, code: i32) -> String {
        assert_eq!((self.stdout.as_str(), self.stderr.lines().count()), ("", 1), "{self:?}");
        self.failed(code)
    }

    /// The objects that it printed as JSON.
    ///
    /// # Panics
    /// If it did not succeed, or printed anything else.
    #[track_caller]
    pub fn objects(self) -> Vec<Value> {
        let Self { stdout, .. } = self.done();
        match serde_json::from_str(&stdout) {
            Ok(Value::Array(objects)) if objects.iter().all(Value::is_object) => objects,
            other => panic!("{other:?}: {stdout}"),
        }
    }
}

impl From<Output> for Outcome {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("the commands print UTF-8");
        Self::new(output.status, text(output.stdout), text(output.stderr))
    }
}
