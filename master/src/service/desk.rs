//! What operators may do with a master: look where it stands, hold units back, end it.

use std::fmt;
use std::sync::Arc;

use selftalk_proto::Token;
use selftalk_proto::v1::operation_server::Operation;
use selftalk_proto::v1::{
    Attendance, LookRequest, PauseReply, PauseRequest, Standing, Standings, StopReply, StopRequest,
};
use tokio_util::sync::CancellationToken;
use tonic::{Request, Response, Status};

use super::gate::admission;
use super::handle::Handle;

/// Knows where the replications stand.
pub trait Roll: fmt::Debug + Send + Sync + 'static {
    /// All of them, in their order.
    fn standings(&self) -> Vec<Standing>;
}

/// Where operators call.
#[derive(Debug)]
pub(super) struct Desk {
    /// What they must know. Without one nobody is an operator.
    pub(super) token: Option<Token>,
    pub(super) handle: Handle,
    pub(super) roll: Arc<dyn Roll>,
    /// Cancelled to end the run.
    pub(super) run: CancellationToken,
}

impl Desk {
    /// Whether whoever asks is an operator.
    fn admit<T>(&self, request: &Request<T>) -> Result<(), Status> {
        let from = admission(request).map(|admission| admission.from());
        let Some(token) = &self.token else {
            return Err(Status::permission_denied(
                "this master has no operators, as it was started without --operator-token-file",
            ));
        };
        if token.admits(request.metadata()) {
            return Ok(());
        }
        tracing::warn!(?from, "a call without the operators' token was refused");
        Err(Status::unauthenticated(
            "this master asks for its operators' token, and none or another was given",
        ))
    }
}

#[tonic::async_trait]
impl Operation for Desk {
    async fn look(&self, request: Request<LookRequest>) -> Result<Response<Standings>, Status> {
        self.admit(&request)?;
        let floor = self.handle.floor();
        let floor = floor.borrow();
        Ok(Response::new(Standings {
            replications: self.roll.standings(),
            workers: floor.workers.iter().map(attendance).collect(),
            paused: floor.paused,
            waiting: floor.waiting as u64,
            leased: floor.leased as u64,
        }))
    }

    async fn pause(&self, request: Request<PauseRequest>) -> Result<Response<PauseReply>, Status> {
        self.admit(&request)?;
        self.handle.pause(request.into_inner().paused).await;
        Ok(Response::new(PauseReply {}))
    }

    async fn stop(&self, request: Request<StopRequest>) -> Result<Response<StopReply>, Status> {
        self.admit(&request)?;
        tracing::warn!("an operator has ended the run");
        self.run.cancel();
        Ok(Response::new(StopReply {}))
    }
}

fn attendance(worker: &super::Attendance) -> Attendance {
    Attendance {
        worker: worker.worker.0,
        host: worker.host.to_string(),
        slots: worker.slots,
        units: worker.units as u64,
        trials: worker.trials,
        trials_per_second: worker.trials_per_second,
        silence_ms: u64::try_from(worker.silence.as_millis()).unwrap_or(u64::MAX),
    }
}
