//! A command that is running.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

use crate::{Outcome, wait_until};

/// A command that is running. It is killed when this is dropped, so that a failed test leaves nothing behind.
#[derive(Debug)]
pub struct Running {
    child: Child,
    stdout: Option<JoinHandle<String>>,
    reported: Arc<Mutex<String>>,
    stderr: Option<JoinHandle<()>>,
}

impl Running {
    /// Starts a command.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn start(mut command: Command) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut stdout = child.stdout.take().unwrap();
        let printed = move || {
            let mut text = String::new();
            stdout.read_to_string(&mut text).map(|_| text).unwrap()
        };
        let stderr = BufReader::new(child.stderr.take().unwrap());
        let reported: Arc<Mutex<String>> = Arc::default();
        let heard = Arc::clone(&reported);
        let listen = move || {
            for line in stderr.lines().map_while(Result::ok) {
                let mut heard = heard.lock().unwrap();
                heard.push_str(&line);
                heard.push('\n');
            }
        };
        let (stdout, stderr) = (std::thread::spawn(printed), std::thread::spawn(listen));
        Self { child, stdout: Some(stdout), reported, stderr: Some(stderr) }
    }

    /// Its process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether it goes on.
    ///
    /// # Panics
    /// If the system does not know.
    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// What it has reported on stderr until now.
    ///
    /// # Panics
    /// If reading it failed.
    #[must_use]
    pub fn reported(&self) -> String {
        self.reported.lock().unwrap().clone()
    }

    /// Waits until it has reported these words on stderr; false if it ends without.
    ///
    /// # Panics
    /// If neither happens.
    #[must_use]
    pub fn reports(&mut self, words: &str) -> bool {
        wait_until(words, || {
            let running = self.is_running();
            let reported = self.reported().contains(words);
            (reported || !running).then_some(reported)
        })
    }

    /// The address a dashboard says it is at, as `HOST:PORT`.
    ///
    /// # Panics
    /// If it ends without saying so.
    #[must_use]
    pub fn dashboard(&mut self) -> String {
        wait_until("the dashboard listens", || {
            let running = self.is_running();
            let reported = self.reported();
            let address =
                reported.lines().find_map(|line| line.strip_prefix("dashboard: http://")?.split('/').next());
            assert!(running || address.is_some(), "{reported}");
            address.map(str::to_owned)
        })
    }

    /// The address a master says it listens on.
    ///
    /// # Panics
    /// If it ends without saying so.
    #[must_use]
    pub fn address(&mut self) -> String {
        wait_until("the master listens", || {
            let running = self.is_running();
            let reported = self.reported();
            let address =
                reported.lines().find_map(|line| line.strip_prefix("listening on ")?.split(';').next());
            assert!(running || address.is_some(), "{reported}");
            address.map(str::to_owned)
        })
    }

    /// Sends a signal, such as Ctrl-C's, unless it has ended already.
    ///
    /// # Panics
    /// If the system does not let it.
    #[cfg(unix)]
    pub fn signal(&mut self, signal: rustix::process::Signal) {
        if self.is_running() {
            rustix::process::kill_process(rustix::process::Pid::from_child(&self.child), signal).unwrap();
        }
    }

    /// Ends it without any chance to tidy up; false if it has ended already.
    ///
    /// # Panics
    /// If the system does not let it.
    #[must_use]
    pub fn kill(mut self) -> bool {
        self.child.kill().unwrap();
        // No exit code: the signal ended it.
        self.child.wait().unwrap().code().is_none()
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// If it does not end.
    #[must_use]
    pub fn end(mut self) -> Outcome {
        let reported = Arc::clone(&self.reported);
        let what = || format!("the end of process {}: {}", self.child.id(), reported.lock().unwrap());
        let what = what();
        let status = wait_until(&what, || self.child.try_wait().unwrap());
        let stdout = self.stdout.take().unwrap().join().unwrap();
        self.stderr.take().unwrap().join().unwrap();
        Outcome::new(status, stdout, self.reported())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended on its own.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
