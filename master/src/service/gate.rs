//! Who may be connected at all: so many at once, and each of them has to become a worker soon.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Sleep, sleep};
use tokio_stream::Stream;
use tonic::Request;
use tonic::transport::server::{Connected, TlsConnectInfo};

/// Connections at the same time. More are closed at once; workers come again.
const MOST: usize = 4096;
/// How long a connection may be there without belonging to a worker that was let in. What only asks whether there is a
/// master needs less.
const SOON: Duration = Duration::from_secs(30);
/// How long nothing is accepted after it has failed, as when the process may open no more files.
const BREATH: Duration = Duration::from_millis(100);

/// The connections that come in at a port.
pub fn connections(listener: TcpListener) -> impl Stream<Item = io::Result<Guest>> {
    Gate { listener, room: Arc::new(Semaphore::new(MOST)), breath: None }
}

/// Where connections come in.
struct Gate {
    listener: TcpListener,
    room: Arc<Semaphore>,
    /// Lasts while nothing is accepted.
    breath: Option<Pin<Box<Sleep>>>,
}

impl Gate {
    /// Lets a connection in if there is room for it.
    fn admit(&self, stream: TcpStream, from: SocketAddr) -> Option<Guest> {
        let Ok(permit) = Arc::clone(&self.room).try_acquire_owned() else {
            tracing::warn!(%from, "a connection was closed: there are {MOST} already");
            return None;
        };
        // A worker sends many small messages; each is to be seen at once. This fails where it is gone again already.
        stream.set_nodelay(true).ok().map(|()| Guest::new(stream, from, permit))
    }
}

impl Stream for Gate {
    type Item = io::Result<Guest>;

    /// Goes on for ever: a failure to accept a connection is none of the service.
    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        loop {
            if let Some(breath) = &mut self.breath {
                ready!(breath.as_mut().poll(context));
                self.breath = None;
            }
            match ready!(self.listener.poll_accept(context)) {
                Ok((stream, from)) => {
                    if let Some(guest) = self.admit(stream, from) {
                        return Poll::Ready(Some(Ok(guest)));
                    }
                }
                Err(error) => {
                    tracing::warn!(%error, "no connection could be accepted");
                    self.breath = Some(Box::pin(sleep(BREATH)));
                }
            }
        }
    }
}

/// A connection. It is closed if it is not let in soon.
#[derive(Debug)]
pub struct Guest {
    stream: TcpStream,
    admission: Admission,
    /// None once it was let in.
    deadline: Option<Pin<Box<Sleep>>>,
    _permit: OwnedSemaphorePermit,
}

/// Lets a connection stay.
#[derive(Debug, Clone)]
pub struct Admission {
    from: SocketAddr,
    granted: Arc<AtomicBool>,
}

impl Admission {
    /// The other end's address.
    pub(super) fn from(&self) -> SocketAddr {
        self.from
    }

    pub(super) fn grant(&self) {
        self.granted.store(true, Ordering::Relaxed);
    }
}

/// What belongs to the connection over which something is asked; none where that is no [`Guest`].
pub(super) fn admission<T>(request: &Request<T>) -> Option<Admission> {
    let encrypted = || request.extensions().get::<TlsConnectInfo<Admission>>().map(TlsConnectInfo::get_ref);
    request.extensions().get::<Admission>().or_else(encrypted).cloned()
}

impl Guest {
    fn new(stream: TcpStream, from: SocketAddr, permit: OwnedSemaphorePermit) -> Self {
        let admission = Admission { from, granted: Arc::default() };
        Self { stream, admission, deadline: Some(Box::pin(sleep(SOON))), _permit: permit }
    }
}

impl Connected for Guest {
    type ConnectInfo = Admission;

    fn connect_info(&self) -> Admission {
        self.admission.clone()
    }
}

impl AsyncRead for Guest {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if self.admission.granted.load(Ordering::Relaxed) {
            self.deadline = None;
        }
        if let Some(deadline) = &mut self.deadline
            && deadline.as_mut().poll(context).is_ready()
        {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

impl AsyncWrite for Guest {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}
