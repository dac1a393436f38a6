//! A worker's settings.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

use selftalk_proto::{SLOT_LIMIT, Token};
use tonic::transport::ClientTlsConfig;

/// A worker's settings.
#[derive(Debug, Clone)]
pub struct Config {
    /// Address of the master, such as `http://127.0.0.1:7700`, or `https://node1:7700` with `tls`.
    pub master: String,
    /// Threads that simulate, 1 to [`SLOT_LIMIT`].
    pub slots: u32,
    /// How long a master is tried that has never been reached.
    pub connect_timeout: Duration,
    /// Fingerprint under which the worker's simulator is announced.
    pub fingerprint: String,
    /// The token that the master asks for, if it does.
    pub token: Option<Token>,
    /// Whom to trust when the line is encrypted, and who to be.
    pub tls: Option<ClientTlsConfig>,
    instance: u64,
}

impl Config {
    /// A worker for this master with this simulator (see [`selftalk_sim::fingerprint()`]), and one slot for every core.
    #[must_use]
    pub fn new(master: impl Into<String>, fingerprint: impl Into<String>) -> Self {
        Self {
            master: master.into(),
            slots: available_cores(),
            connect_timeout: Duration::from_secs(30),
            fingerprint: fingerprint.into(),
            token: None,
            tls: None,
            // The standard library's hasher is seeded at random.
            instance: RandomState::new().build_hasher().finish(),
        }
    }

    /// The same with an instance of the caller's choice, for a network that plays out in the same way every time.
    #[must_use]
    pub fn with_instance(self, instance: u64) -> Self {
        Self { instance, ..self }
    }

    /// Tells this worker from all others; it stays the same when the worker reconnects.
    #[must_use]
    pub fn instance(&self) -> u64 {
        self.instance
    }
}

/// Cores this process may use, as far as a worker can make use of them.
#[must_use]
pub fn available_cores() -> u32 {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    u32::try_from(cores).unwrap_or(SLOT_LIMIT).min(SLOT_LIMIT)
}

/// The machine's name, as far as it can be told without asking the network.
pub(crate) fn host() -> String {
    let file = |path| std::fs::read_to_string(path).ok();
    let names = [
        file("/proc/sys/kernel/hostname"),
        file("/etc/hostname"),
        std::env::var("HOSTNAME").ok(),
        std::env::var("COMPUTERNAME").ok(),
    ];
    let known = |name: String| Some(name.trim().to_owned()).filter(|name| !name.is_empty());
    names.into_iter().flatten().find_map(known).unwrap_or_else(|| "unknown".to_owned())
}
