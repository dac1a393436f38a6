//! Answers, and why there may be none.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::store::StoreError;

/// Why a request is not answered with what it asks for.
#[derive(Debug)]
pub(super) enum Refusal {
    /// There is no such thing.
    Missing(String),
    /// It is there, and cannot be had from this program.
    Impossible(String),
    /// Too many ask for the same at once.
    Busy,
    /// There is nothing to show yet, or no more.
    Dark,
    /// Something has failed here.
    Failed(String),
}

#[derive(Serialize)]
struct Words {
    error: String,
}

impl Refusal {
    pub(super) fn missing(what: &str, name: impl std::fmt::Display) -> Self {
        Self::Missing(format!("there is no {what} {name}"))
    }

    pub(super) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    pub(super) fn status(&self) -> StatusCode {
        match self {
            Self::Missing(_) => StatusCode::NOT_FOUND,
            Self::Impossible(_) => StatusCode::CONFLICT,
            Self::Busy | Self::Dark => StatusCode::SERVICE_UNAVAILABLE,
            Self::Failed(_) => StatusCode::INTERNAL_SERVER_ERROR,
        }
    }

    pub(super) fn words(self) -> String {
        match self {
            Self::Missing(words) | Self::Impossible(words) | Self::Failed(words) => words,
            Self::Busy => "other replays are being made; try again in a moment".to_owned(),
            Self::Dark => {
                "the database is not open: the command has just begun, or is about to end".to_owned()
            }
        }
    }
}

impl From<StoreError> for Refusal {
    fn from(error: StoreError) -> Self {
        Self::failed(error)
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        (self.status(), json(&Words { error: self.words() })).into_response()
    }
}

/// An answer as JSON, which is out of date as soon as it is given.
pub(super) fn json(value: &impl Serialize) -> Response {
    match serde_json::to_vec(value) {
        Ok(body) => typed("application/json", body),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// An answer of some type, not to be kept.
pub(super) fn typed(kind: &'static str, body: impl IntoResponse) -> Response {
    let mut response = body.into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(kind));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

/// Six digits behind the point are more than a picture can show.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
