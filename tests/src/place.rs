//! A folder with an experiment and its history.

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;

use crate::{Outcome, Running, selftalk, wait_until, worker};

/// An experiment that takes a second or two: two replications of twelve small generations, short trials.
pub const SMALL: &str = "\
name = \"small\"
seed = 7
replications = 2
generations = 12

[evolution]
population = 20
parents = 4
mutation = 0.01

[reach]
steps = 8

[open]
steps = 8

[grasp]
steps = 8

[move]
steps = 8
";

/// What `selftalk digest` says of [`SMALL`], by replication, however it was run, in every build and on every machine.
///
/// It changes only with what the simulator or the evolution computes, or with the defaults of an experiment. When that was the
/// intention, take the new values from the failure of `cargo test --workspace oracle::`; after the former, histories begun before
/// cannot be continued.
pub const GOLDEN: [&str; 2] = [
    "fa137d004dff7dc123d31afd2d9ad015f7fe68b9b7a0c99b48897aaf6f5a5c1f",
    "4ae33a071c8ab0c8d6698f1b5f113318d3677d049f5acf5aa8ccb49f8e3f915c",
];

/// A folder with the experiment [`SMALL`] in `small.toml`, whose history is `history.db`.
#[derive(Debug)]
pub struct Place {
    folder: PathBuf,
    _temporary: Option<TempDir>,
}

impl Place {
    /// A new place.
    ///
    /// # Panics
    /// If the system has no place for temporary files.
    #[must_use]
    pub fn new() -> Self {
        let temporary = tempfile::tempdir().unwrap();
        let place = Self { folder: temporary.path().to_owned(), _temporary: Some(temporary) };
        place.write("small.toml", SMALL);
        place
    }

    /// A place in a folder that stays, or goes, on its own.
    #[must_use]
    pub fn in_folder(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), _temporary: None }
    }

    /// A file or folder in it.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file.
    ///
    /// # Panics
    /// If that is not possible.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Reads a file.
    ///
    /// # Panics
    /// If that is not possible.
    #[must_use]
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Starts `selftalk` in it; the words are separated by spaces.
    #[must_use]
    pub fn start(&self, words: &str) -> Running {
        let mut command = selftalk();
        command.current_dir(&self.folder).args(["--db", "history.db"]).args(words.split_whitespace());
        Running::start(command)
    }

    /// Starts a `selftalk-worker` with one slot for the master at this address.
    #[must_use]
    pub fn start_worker(&self, address: &str) -> Running {
        let mut command = worker();
        command.current_dir(&self.folder).args(["--slots", "1", "--master", &format!("http://{address}")]);
        Running::start(command)
    }

    /// Runs `selftalk` in it to its end.
    #[must_use]
    pub fn run(&self, words: &str) -> Outcome {
        self.start(words).end()
    }

    /// A new place in which [`SMALL`] has run for so many generations.
    #[must_use]
    pub fn with_history(generations: u64) -> Self {
        let place = Self::new();
        place.run(&format!("run small.toml --set generations={generations}")).done();
        place
    }

    /// What a command prints as JSON.
    #[must_use]
    pub fn ask(&self, words: &str) -> Vec<Value> {
        self.run(&format!("{words} --format json")).objects()
    }

    /// The digests of the replications of [`SMALL`].
    ///
    /// # Panics
    /// If there is no history.
    #[must_use]
    pub fn digests(&self) -> Vec<String> {
        let digests = self.ask("digest small");
        digests.iter().map(|line| line["sha256"].as_str().unwrap().to_owned()).collect()
    }

    /// Generations that have been committed, over all replications; 0 while there is no history.
    ///
    /// # Panics
    /// If the history cannot be read.
    #[must_use]
    pub fn generations(&self) -> u64 {
        if !self.path("history.db").exists() {
            return 0;
        }
        let outcome = self.run("history replications --format json");
        if outcome.code != Some(0) {
            // The master has created the file and not yet its tables.
            return 0;
        }
        outcome.objects().iter().map(|line| line["generations"].as_u64().unwrap()).sum()
    }

    /// Waits until a run is under way: two generations have been committed.
    pub fn wait_half_way(&self) {
        wait_until("some generations", || (self.generations() >= 2).then_some(()));
    }

    /// Whether there is still much to do. A run that a test disturbs now cannot end before the test is ready.
    #[must_use]
    pub fn is_half_way(&self) -> bool {
        (2..20).contains(&self.generations())
    }

    /// Gives new places to `disturb` until it could do its work in the middle of a run, and returns the last: on a
    /// busy machine a run may go on by itself for too long.
    ///
    /// # Panics
    /// When `disturb` comes too late again and again.
    #[must_use]
    pub fn disturbed(mut disturb: impl FnMut(&Self) -> bool) -> Self {
        let place = (0..10).map(|_| Self::new()).find(|place| disturb(place));
        place.expect("a run that takes long enough to be disturbed")
    }
}

impl Default for Place {
    fn default() -> Self {
        Self::new()
    }
}
