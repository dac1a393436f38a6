//! Where the dashboard is.

use std::net::SocketAddr;
use std::str::FromStr;

use clap::Args;

/// Where the dashboard of a run is.
#[derive(Debug, Clone, Args)]
pub struct Shown {
    /// Address and port of the dashboard, a page that shows the run in a browser, or `off`
    /// [default: 127.0.0.1:7780, or another port if that is taken]
    #[arg(long, value_name = "ADDRESS|off")]
    pub dashboard: Option<DashboardAt>,
    /// Listen where other machines can come in, though nothing is encrypted: only in a network that is trusted
    #[arg(long)]
    pub insecure: bool,
}

/// Arguments of `selftalk dashboard`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The database is only read. It may be finished or not, of another release's simulator, and written by a master meanwhile;
what that master's workers are at is shown by its own dashboard only. Ctrl-C ends it.

Examples:
  selftalk dashboard --db study/study.db
  selftalk dashboard --listen 127.0.0.1:8080

`selftalk --help` lists the exit codes.")]
pub struct DashboardArgs {
    /// Address and port to listen on [default: 127.0.0.1:7780, or another port if that is taken]
    #[arg(long, value_name = "ADDRESS")]
    pub listen: Option<SocketAddr>,
    /// Listen where other machines can come in, though nothing is encrypted: only in a network that is trusted
    #[arg(long)]
    pub insecure: bool,
}

/// Where a dashboard is, if anywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DashboardAt {
    /// Nowhere.
    Off,
    /// At an address.
    At(SocketAddr),
}

impl FromStr for DashboardAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "off" {
            return Ok(Self::Off);
        }
        let address = text.parse().map(Self::At);
        address.map_err(|_| "expected an IP address with a port, such as 127.0.0.1:7780, or `off`".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dashboard_is_off_or_at_an_address() {
        assert_eq!("off".parse(), Ok(DashboardAt::Off));
        assert_eq!("[::1]:80".parse(), Ok(DashboardAt::At("[::1]:80".parse().unwrap())));
        for text in ["", "on", "7780", "localhost:7780", "127.0.0.1"] {
            let message = text.parse::<DashboardAt>().unwrap_err();
            assert!(message.contains("such as 127.0.0.1:7780, or `off`"), "{message}");
        }
    }
}
