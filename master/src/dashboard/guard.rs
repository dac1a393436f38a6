//! Which requests are answered at all, and what every answer says beside its content.

use std::net::IpAddr;

use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// What the dashboard's own pages may load: its own files.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const ALWAYS: [(HeaderName, &str); 4] = [
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// Lets requests through that only read, and, where only this machine can reach the dashboard, that ask for this machine.
pub(super) async fn guard(State(local): State<bool>, request: Request, next: Next) -> Response {
    let mut response = if !matches!(*request.method(), Method::GET | Method::HEAD) {
        let words = "the dashboard only reads: GET and HEAD are answered";
        (StatusCode::METHOD_NOT_ALLOWED, [(header::ALLOW, "GET, HEAD")], words).into_response()
    } else if local && !asks_for_this_machine(&request) {
        let words = "the dashboard is for this machine alone: ask for localhost or 127.0.0.1";
        (StatusCode::FORBIDDEN, words).into_response()
    } else {
        next.run(request).await
    };
    let headers = response.headers_mut();
    for (name, value) in ALWAYS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // A replay has a policy of its own.
    headers.entry(header::CONTENT_SECURITY_POLICY).or_insert_with(|| HeaderValue::from_static(POLICY));
    response
}

/// A page of another host whose name was made to mean this machine would say that name.
fn asks_for_this_machine(request: &Request) -> bool {
    let named = request.headers().get(header::HOST).and_then(|host| host.to_str().ok());
    named.is_some_and(is_this_machine)
        && request.uri().authority().is_none_or(|authority| is_this_machine(authority.as_str()))
}

/// Whether `HOST[:PORT]` is this machine; any port, as it may have been forwarded.
fn is_this_machine(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => rest.split_once(']').map_or("", |(address, _)| address),
        None => host.split_once(':').map_or(host, |(name, _)| name),
    };
    name.eq_ignore_ascii_case("localhost") || name.parse().is_ok_and(|address: IpAddr| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_has_few_names() {
        for host in ["localhost", "LocalHost:7780", "127.0.0.1:7780", "127.1.2.3", "[::1]:7780", "[::1]"] {
            assert!(is_this_machine(host), "{host}");
        }
        let others =
            ["", "example.org", "localhost.example.org:7780", "127.0.0.1.example.org", "192.0.2.1", "::1"];
        for host in others {
            assert!(!is_this_machine(host), "{host}");
        }
    }
}
