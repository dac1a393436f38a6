//! Chromium without a window, told what to do over the DevTools protocol.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::wait_until;

/// A browser with one page. It ends when this is dropped.
#[derive(Debug)]
pub struct Browser {
    process: Child,
    orders: File,
    answers: BufReader<File>,
    session: Value,
    order: u64,
    /// What pages have complained about: errors on the console, exceptions, what was blocked or not found.
    complaints: Vec<String>,
    _folder: TempDir,
}

impl Browser {
    /// Starts Chromium; none, with a word on stderr, if there is none.
    ///
    /// # Panics
    /// If it is there and cannot be told anything.
    #[must_use]
    pub fn start() -> Option<Self> {
        if let Err(error) = Command::new("chromium").arg("--version").output() {
            eprintln!("chromium: {error}; pages are not tested in a browser");
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        assert!(Command::new("mkfifo").args([path("orders"), path("answers")]).status().unwrap().success());
        // Chromium reads orders from its file 3 and answers on its file 4.
        let mut browser = Command::new("sh");
        browser.args(["-c", "exec chromium \"$@\" 3<\"$0/orders\" 4>\"$0/answers\""]).arg(folder.path());
        browser.args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--remote-debugging-pipe",
        ]);
        browser.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
        browser.arg(format!("--user-data-dir={}", path("profile").display()));
        browser.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let process = browser.spawn().unwrap();
        // Each waits until the other side is opened.
        let orders = OpenOptions::new().write(true).open(path("orders")).unwrap();
        let answers = BufReader::new(File::open(path("answers")).unwrap());
        let mut browser = Self {
            process,
            orders,
            answers,
            session: Value::Null,
            order: 0,
            complaints: Vec::new(),
            _folder: folder,
        };
        let page = browser.tell("Target.createTarget", json!({ "url": "about:blank" }));
        let to = json!({ "targetId": page["targetId"], "flatten": true });
        browser.session = browser.tell("Target.attachToTarget", to)["sessionId"].clone();
        for domain in ["Page", "Runtime", "Log"] {
            browser.tell(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Gives an order and returns what comes of it.
    ///
    /// # Panics
    /// If it is not understood, or the browser is gone.
    pub fn tell(&mut self, method: &str, params: Value) -> Value {
        self.order += 1;
        let mut order = json!({ "id": self.order, "method": method, "params": params });
        if !self.session.is_null() {
            order["sessionId"] = self.session.clone();
        }
        self.orders.write_all(format!("{order}\0").as_bytes()).unwrap();
        loop {
            let mut message = Vec::new();
            self.answers.read_until(0, &mut message).unwrap();
            assert_eq!(message.pop(), Some(0), "the browser is gone");
            let mut message: Value = serde_json::from_slice(&message).unwrap();
            if message["id"] == self.order {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].take();
            }
            self.listen(&message);
        }
    }

    fn listen(&mut self, event: &Value) {
        let params = &event["params"];
        let complaint = match event["method"].as_str() {
            Some("Runtime.consoleAPICalled") => matches!(params["type"].as_str(), Some("error" | "warning")),
            Some("Log.entryAdded") => matches!(params["entry"]["level"].as_str(), Some("error" | "warning")),
            Some("Runtime.exceptionThrown") => true,
            _ => false,
        };
        if complaint {
            self.complaints.push(params.to_string());
        }
    }

    /// Goes to an address.
    pub fn go(&mut self, address: &str) {
        let gone = self.tell("Page.navigate", json!({ "url": address }));
        assert!(gone["errorText"].is_null(), "{address}: {gone}");
    }

    /// What an expression is in the page.
    ///
    /// # Panics
    /// If it throws.
    pub fn eval(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut done = self.tell("Runtime.evaluate", params);
        assert!(done["exceptionDetails"].is_null(), "{expression}: {done}");
        done["result"]["value"].take()
    }

    /// Waits until an expression is true in the page, whichever page that is by then.
    ///
    /// # Panics
    /// If it never is.
    pub fn wait(&mut self, expression: &str) {
        let safe =
            format!("(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()");
        wait_until(expression, || (self.eval(&safe) == true).then_some(()));
    }

    /// Presses a key.
    pub fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.tell("Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "code": key }));
        }
    }

    /// Shows the page in a window of this width, as on a phone.
    pub fn narrow(&mut self, width: u32) {
        let size = json!({ "width": width, "height": 740, "deviceScaleFactor": 1, "mobile": true });
        self.tell("Emulation.setDeviceMetricsOverride", size);
    }

    /// Prefers light or dark.
    pub fn prefer(&mut self, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.tell("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Makes sure that no page has complained so far.
    ///
    /// # Panics
    /// If one has.
    pub fn assert_content(&mut self) {
        // What was said before the answer has come with it.
        self.eval("1");
        assert!(self.complaints.is_empty(), "{:#?}", self.complaints);
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its own processes end with it.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
