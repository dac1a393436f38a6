//! The master's open lines, which end in one order when it crashes.

use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tonic::transport::server::Connected;
use turmoil::net::TcpStream;

type Slot = Arc<Mutex<Option<TcpStream>>>;

/// What the other side of a line hears of its end takes a time that is drawn for each line in turn. A crash drops the tasks
/// that hold the lines, in an order that depends on how many tasks the process has ever had, other simulations' included.
/// Therefore all lines are kept here as well, and end in the order in which they were opened.
#[derive(Clone, Default)]
pub(super) struct Lines {
    open: Arc<Mutex<Vec<Slot>>>,
    crashing: Arc<AtomicBool>,
}

impl Lines {
    /// Takes in a line that was opened.
    pub(super) fn open(&self, stream: TcpStream) -> Line {
        let slot = Arc::new(Mutex::new(Some(stream)));
        locked(&self.open).push(Arc::clone(&slot));
        Line { slot, lines: self.clone() }
    }

    /// Does what may crash the master.
    pub(super) fn crash(&self, crash: impl FnOnce()) {
        self.crashing.store(true, Ordering::Relaxed);
        crash();
        self.crashing.store(false, Ordering::Relaxed);
    }
}

/// A connection as the service takes it.
pub(super) struct Line {
    slot: Slot,
    lines: Lines,
}

impl Line {
    /// Does something with the stream, if it has not ended.
    fn poll<T>(&self, poll: impl FnOnce(Pin<&mut TcpStream>) -> Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        match &mut *locked(&self.slot) {
            Some(stream) => poll(Pin::new(stream)),
            None => Poll::Ready(Err(io::ErrorKind::BrokenPipe.into())),
        }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        let mut open = locked(&self.lines.open);
        if self.lines.crashing.load(Ordering::Relaxed) {
            open.drain(..).for_each(|slot| drop(locked(&slot).take()));
        } else {
            open.retain(|slot| !Arc::ptr_eq(slot, &self.slot));
        }
    }
}

impl Connected for Line {
    type ConnectInfo = ();

    fn connect_info(&self) {}
}

impl AsyncRead for Line {
    fn poll_read(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.poll(|stream| stream.poll_read(context, into))
    }
}

impl AsyncWrite for Line {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.poll(|stream| stream.poll_write(context, bytes))
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.poll(|stream| stream.poll_flush(context))
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.poll(|stream| stream.poll_shutdown(context))
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("no panic")
}
