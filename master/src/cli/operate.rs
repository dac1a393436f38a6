//! `selftalk operate`.

use std::time::Duration;

use selftalk_proto::v1::operation_client::OperationClient;
use selftalk_proto::v1::{LookRequest, PauseRequest, Standings, StopRequest};
use selftalk_proto::{ClientKeys, Token, chain, endpoint};
use tonic::transport::Channel;
use tonic::{Code, Request, Status};

use super::Global;
use super::args::{OperateArgs, OperateAt, OperateCommand};
use super::output::Table;
use crate::exit::{Exit, Failure};

/// How long a master has to answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: OperateArgs, global: &Global) -> Result<(), Failure> {
    let OperateArgs { at, what } = args;
    let mut master = Master::reach(&at).await?;
    match what {
        OperateCommand::Standings => standings(&master.look().await?).print(global.format),
        OperateCommand::Workers => workers(&master.look().await?).print(global.format),
        OperateCommand::Pause => {
            master.pause(true).await?;
            eprintln!("no more work is given out; `selftalk operate continue` gives it out again");
            Ok(())
        }
        OperateCommand::Continue => {
            master.pause(false).await?;
            eprintln!("work is given out");
            Ok(())
        }
        OperateCommand::Stop => {
            master.stop().await?;
            eprintln!("the master ends; all complete generations are kept");
            Ok(())
        }
    }
}

/// A master, as its operators reach it.
struct Master {
    address: String,
    token: Token,
    client: OperationClient<Channel>,
}

impl Master {
    /// # Errors
    /// [`Exit::Usage`] when keys, token or address cannot be used, [`Exit::Network`] when nobody answers there.
    async fn reach(at: &OperateAt) -> Result<Self, Failure> {
        let OperateAt { master: address, keys, token_file } = at;
        let usage = |error: &dyn std::fmt::Display| Failure::new(Exit::Usage, error);
        let variable = std::env::var(Token::VARIABLE).ok();
        let token =
            Token::given(token_file.as_deref(), variable.as_deref()).map_err(|error| usage(&error))?;
        let keys = keys.as_deref().map(ClientKeys::read).transpose().map_err(|error| usage(&error))?;
        let (tls, among_keys) = keys.map_or((None, None), |keys| (Some(keys.tls), keys.token));
        let token = token.or(among_keys).ok_or_else(|| {
            usage(&"a master asks for its operators' token: give it with --keys, --token-file or SELFTALK_TOKEN")
        })?;
        let endpoint = endpoint(address, tls.as_ref()).map_err(|error| usage(&error))?;
        let endpoint = endpoint.connect_timeout(PATIENCE).timeout(PATIENCE);
        let channel = endpoint.connect().await.map_err(|error| {
            Failure::new(Exit::Network, format!("{address}: no master reached: {}", chain(&error)))
        })?;
        Ok(Self { address: address.clone(), token, client: OperationClient::new(channel) })
    }

    async fn look(&mut self) -> Result<Standings, Failure> {
        let request = self.request(LookRequest {});
        let answer = self.client.look(request).await;
        Ok(answer.map_err(|status| self.failure(&status))?.into_inner())
    }

    async fn pause(&mut self, paused: bool) -> Result<(), Failure> {
        let request = self.request(PauseRequest { paused });
        let answer = self.client.pause(request).await;
        answer.map(|_| ()).map_err(|status| self.failure(&status))
    }

    async fn stop(&mut self) -> Result<(), Failure> {
        let request = self.request(StopRequest {});
        let answer = self.client.stop(request).await;
        answer.map(|_| ()).map_err(|status| self.failure(&status))
    }

    fn request<T>(&self, message: T) -> Request<T> {
        let mut request = Request::new(message);
        self.token.attach(request.metadata_mut());
        request
    }

    fn failure(&self, status: &Status) -> Failure {
        let text = match status.code() {
            Code::Unimplemented => "there is no selftalk master at this address".to_owned(),
            Code::Unauthenticated | Code::PermissionDenied => format!("refused: {}", status.message()),
            _ if status.message().is_empty() => chain(status),
            _ => status.message().to_owned(),
        };
        Failure::new(Exit::Network, format!("{}: {text}", self.address))
    }
}

fn standings(seen: &Standings) -> Table {
    let mut table = Table::new([
        "experiment",
        "replication",
        "state",
        "generations",
        "planned",
        "best_fitness",
        "successes",
        "trials",
    ]);
    for standing in &seen.replications {
        let state = match (standing.finished, seen.paused) {
            (true, _) => "finished",
            (false, true) => "paused",
            (false, false) => "running",
        };
        table.push([
            standing.experiment.as_str().into(),
            standing.replication.into(),
            state.into(),
            standing.generations.into(),
            standing.of.into(),
            standing.best_fitness.into(),
            standing.best_successes.into(),
            standing.trials.into(),
        ]);
    }
    table
}

fn workers(seen: &Standings) -> Table {
    let mut table =
        Table::new(["worker", "host", "slots", "units", "trials", "trials_per_second", "silent_seconds"]);
    for worker in &seen.workers {
        table.push([
            worker.worker.into(),
            worker.host.as_str().into(),
            worker.slots.into(),
            worker.units.into(),
            worker.trials.into(),
            worker.trials_per_second.into(),
            Duration::from_millis(worker.silence_ms).as_secs_f64().into(),
        ]);
    }
    table
}
