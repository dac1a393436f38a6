//! A request to a page, without a browser.

use std::io::{Read, Write};
use std::net::TcpStream;

use serde_json::Value;

use crate::PATIENCE;

/// An answer to a request.
#[derive(Debug)]
pub struct Page {
    /// The status.
    pub status: u16,
    /// The headers, in lower case.
    pub head: String,
    /// The content.
    pub body: String,
}

impl Page {
    /// Sends a request line and headers to `HOST:PORT`, and waits for the whole answer; none if nobody
    /// listens, or no longer.
    ///
    /// # Panics
    /// If the answer is none.
    #[must_use]
    pub fn request(address: &str, request: &str, host: &str) -> Option<Self> {
        let mut stream = TcpStream::connect(address).ok()?;
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "{request} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").ok()?;
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).ok()?;
        let answer = String::from_utf8(bytes).expect("pages are UTF-8");
        let (head, body) = answer.split_once("\r\n\r\n")?;
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok());
        Some(Self { status: status.unwrap(), head: head.to_lowercase(), body: body.to_owned() })
    }

    /// Asks for a page.
    ///
    /// # Panics
    /// If nobody listens.
    #[must_use]
    pub fn get(address: &str, path: &str) -> Self {
        Self::request(address, &format!("GET {path}"), address).expect("somebody listens")
    }

    /// Asks for JSON.
    ///
    /// # Panics
    /// If there is none.
    #[must_use]
    pub fn json(address: &str, path: &str) -> Value {
        let page = Self::get(address, path);
        assert_eq!(page.status, 200, "{path}: {page:?}");
        serde_json::from_str(&page.body).unwrap_or_else(|error| panic!("{error}: {page:?}"))
    }
}
