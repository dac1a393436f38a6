//! Ctrl-C and SIGTERM, for both commands: the first asks for a clean end, the second ends at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use tokio_util::sync::CancellationToken;

/// Tells when the process was asked to end, and how.
#[derive(Debug, Clone)]
pub struct Signal {
    token: CancellationToken,
    code: Arc<AtomicU8>,
}

impl Signal {
    /// Cancelled when the process is asked to end.
    #[must_use]
    pub fn token(&self) -> CancellationToken {
        self.token.clone()
    }

    /// The exit code that tells of the signal, if there was one: 130 after Ctrl-C, 143 after SIGTERM.
    #[must_use]
    pub fn exit_code(&self) -> Option<u8> {
        Some(self.code.load(Ordering::SeqCst)).filter(|code| *code != 0)
    }
}

/// Begins to watch for signals; must be called within a Tokio runtime.
///
/// # Errors
/// When the system does not allow it.
pub fn watch() -> io::Result<Signal> {
    let signal = Signal { token: CancellationToken::new(), code: Arc::default() };
    let watching = signal.clone();
    let mut signals = Signals::new()?;
    tokio::spawn(async move {
        let code = signals.next().await;
        watching.code.store(code, Ordering::SeqCst);
        watching.token.cancel();
        std::process::exit(signals.next().await.into());
    });
    Ok(signal)
}

#[cfg(unix)]
struct Signals {
    interrupt: tokio::signal::unix::Signal,
    terminate: tokio::signal::unix::Signal,
}

#[cfg(unix)]
impl Signals {
    fn new() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    async fn next(&mut self) -> u8 {
        tokio::select! {
            _ = self.interrupt.recv() => 130,
            _ = self.terminate.recv() => 143,
        }
    }
}

#[cfg(not(unix))]
struct Signals;

#[cfg(not(unix))]
impl Signals {
    fn new() -> io::Result<Self> {
        Ok(Self)
    }

    async fn next(&mut self) -> u8 {
        match tokio::signal::ctrl_c().await {
            Ok(()) => 130,
            Err(_) => std::future::pending().await,
        }
    }
}
