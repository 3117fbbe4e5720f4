//! Chromium in real time by its DevTools protocol over a pipe.
//!
//! Runs the browser that STIFFMAP_CHROMIUM names, else `chromium`. Without one a test is skipped and says so; with
//! STIFFMAP_GPU=require that is a failure.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// How long an answer may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);

pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Vec<u8>>,
    session: Option<String>,
    last: u64,
    /// What the browser said besides answers.
    events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// A browser with a window of the given size, or nothing where there is none.
    pub fn open(gpu: bool, size: [u32; 2]) -> Option<Browser> {
        let profile = tempfile::tempdir().unwrap();
        let program = std::env::var("STIFFMAP_CHROMIUM").unwrap_or_else(|_| "chromium".to_string());
        // The protocol is read from descriptor 3 and written to 4.
        let shell = r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null"#;
        let mut command = Command::new("sh");
        command.args(["-c", shell, "sh", &program, "--remote-debugging-pipe"]);
        command.args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"]);
        command.args([format!("--window-size={},{}", size[0], size[1])]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        if gpu {
            command.args(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]);
        }
        let found = Command::new(&program).arg("--version").output().is_ok_and(|o| o.status.success());
        if !found {
            let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
            assert!(!required, "STIFFMAP_GPU=require and {program} does not start");
            println!("skipped: no chromium");
            return None;
        }
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let (to, out) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (send, from) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(out).split(0) {
                if message.is_err() || send.send(message.unwrap()).is_err() {
                    break;
                }
            }
        });
        let mut browser = Browser { child, to, from, session: None, last: 0, events: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let session = browser.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        browser.session = session["sessionId"].as_str().map(String::from);
        for domain in ["Runtime.enable", "Log.enable", "Page.enable"] {
            browser.call(domain, json!({}));
        }
        Some(browser)
    }

    fn read(&mut self, deadline: Instant) -> Value {
        let left = deadline.saturating_duration_since(Instant::now());
        let message = self.from.recv_timeout(left).unwrap_or_else(|e| panic!("the browser gave no answer: {e}"));
        serde_json::from_slice(&message).unwrap()
    }

    /// Calls a method of the protocol and returns its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        let deadline = Instant::now() + PATIENCE;
        loop {
            let answer = self.read(deadline);
            if answer["id"] == json!(self.last) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// Opens a page and waits until the report on it is ready.
    pub fn report(&mut self, page: &Path, switches: &str) {
        let url = format!("file://{}{switches}", page.display());
        self.call("Page.navigate", json!({ "url": url }));
        let deadline = Instant::now() + PATIENCE;
        while self.evaluate("typeof stiffmap === 'object' && Boolean(stiffmap.ready)") != json!(true) {
            assert!(Instant::now() < deadline, "the page defines nothing: {:?}", self.complaints());
            std::thread::sleep(Duration::from_millis(20));
        }
        self.evaluate("stiffmap.ready.then(() => true)");
    }

    /// The value of an expression, awaited.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let answer = self.call("Runtime.evaluate", parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// Numbers of an expression.
    pub fn numbers(&mut self, expression: &str) -> Vec<f64> {
        let value = self.evaluate(expression);
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    }

    /// Console errors, exceptions and failures of the page.
    pub fn complaints(&self) -> Vec<String> {
        let of = |event: &Value| {
            let parameters = &event["params"];
            let bad = match event["method"].as_str()? {
                "Runtime.exceptionThrown" => true,
                "Runtime.consoleAPICalled" => parameters["type"] == "error",
                "Log.entryAdded" => parameters["entry"]["level"] == "error",
                _ => false,
            };
            bad.then(|| parameters.to_string())
        };
        self.events.iter().filter_map(of).collect()
    }

    /// A picture of the part of the page from its top down to a height.
    pub fn screenshot(&mut self, path: &Path) {
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, decode(answer["data"].as_str().unwrap())).unwrap();
    }
}

/// Bytes of base64.
pub fn decode(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => u32::from(c - b'A'),
        b'a'..=b'z' => u32::from(c - b'a') + 26,
        b'0'..=b'9' => u32::from(c - b'0') + 52,
        b'+' => 62,
        b'/' => 63,
        _ => 0,
    };
    let mut bytes = Vec::new();
    for four in text.as_bytes().chunks(4) {
        let word = four.iter().fold(0, |w, c| w << 6 | value(*c));
        let kept = 3 - four.iter().filter(|c| **c == b'=').count();
        bytes.extend_from_slice(&word.to_be_bytes()[1..=kept]);
    }
    bytes
}
