//! A headless browser that tests control by the DevTools protocol, over pipes.

use super::PATIENCE;
use super::browser::find_browser;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// Time limit of a browser \[s]. A browser that hangs is killed, and its test fails.
const LIMIT: &str = "1500";

/// A browser with one open page.
pub struct DevTools {
    child: Child,
    commands: ChildStdin,
    answers: BufReader<ChildStdout>,
    session: Option<String>,
    count: u64,
    complaints: Vec<String>,
    _profile: tempfile::TempDir,
}

impl DevTools {
    /// Starts a browser with an empty page; returns `None` if none is installed.
    pub fn start() -> Option<Self> {
        let program = find_browser()?;
        let profile = tempfile::tempdir().unwrap();
        // The browser reads commands from descriptor 3 and answers to descriptor 4.
        let line = "exec timeout \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null";
        let mut child = Command::new("sh")
            .args(["-c", line, LIMIT])
            .arg(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"])
            .arg("--remote-debugging-pipe")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (commands, answers) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let complaints = Vec::new();
        let mut tools = Self { child, commands, answers, session: None, count: 0, complaints, _profile: profile };
        let target = tools.call("Target.createTarget", json!({ "url": "about:blank" }));
        let target = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = tools.call("Target.attachToTarget", target);
        tools.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log"] {
            tools.call(&format!("{domain}.enable"), json!({}));
        }
        Some(tools)
    }

    /// Calls a method of the DevTools protocol and returns its result. Collects complaints
    /// meanwhile.
    #[track_caller]
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.count += 1;
        let mut message = json!({ "id": self.count, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        write!(self.commands, "{message}\0").unwrap();
        loop {
            let mut bytes = Vec::new();
            self.answers.read_until(0, &mut bytes).unwrap();
            assert!(!bytes.is_empty(), "the browser has ended");
            bytes.pop();
            let answer: Value = serde_json::from_slice(&bytes).unwrap();
            if answer["id"] == self.count {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            let method = answer["method"].as_str().unwrap_or("");
            // Advice about speed is no complaint: tests read the canvas, which the browser advises
            // against.
            let is_advice = answer["params"]["entry"]["source"] == "rendering";
            let reports = ["Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"];
            if reports.contains(&method) && !is_advice {
                self.complaints.push(answer["params"].to_string());
            }
        }
    }

    /// Opens an address in a window of `width` × `height` pixels.
    pub fn open(&mut self, address: &str, width: u32, height: u32) {
        self.resize(width, height);
        self.call("Page.navigate", json!({ "url": address }));
        // The browser changes the address before the new document has a body.
        self.wait_for(&format!("location.href === '{address}' && document.readyState !== 'loading'"));
    }

    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Tells the page that the user prefers dark colors.
    pub fn prefer_dark_colors(&mut self) {
        let feature = json!({ "name": "prefers-color-scheme", "value": "dark" });
        self.call("Emulation.setEmulatedMedia", json!({ "features": [feature] }));
    }

    /// Evaluates a JavaScript expression in the page and returns its value; awaits promises.
    #[track_caller]
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// Waits until a JavaScript expression is true. Panics after [`PATIENCE`].
    #[track_caller]
    pub fn wait_for(&mut self, condition: &str) {
        let start = Instant::now();
        while self.value(&format!("Boolean({condition})")) != true {
            let status = "document.getElementById('status')?.textContent";
            assert!(start.elapsed() < PATIENCE, "{condition} does not hold: {}", self.value(status));
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Sends a key press to the page.
    pub fn press(&mut self, key: &str) {
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": key, "text": key }));
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
    }

    /// Moves the pointer along `points`. With several points, the left button is held down.
    pub fn drag(&mut self, points: &[(f64, f64)]) {
        let held = points.len() > 1;
        let mut event = |kind: &str, (x, y): (f64, f64), buttons: u32| {
            let button = if buttons > 0 || kind == "mouseReleased" { "left" } else { "none" };
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        };
        event("mouseMoved", points[0], 0);
        if held {
            event("mousePressed", points[0], 1);
            points[1..].iter().for_each(|point| event("mouseMoved", *point, 1));
            event("mouseReleased", points[points.len() - 1], 0);
        }
    }

    /// Returns the exceptions and console messages of the page so far.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }
}

impl Drop for DevTools {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
