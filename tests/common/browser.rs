//! A headless Chromium, driven as the W3C WebDriver protocol says, by the chromedriver beside it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;

/// How elements are named in what goes over the wire.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";

/// How long a page may take until what is waited for is there.
const PATIENCE: Duration = Duration::from_secs(120);

/// A browser with one window.
pub struct Browser {
    driver: Child,
    session: String,
    agent: ureq::Agent,
    _profile: TempDir,
}

/// A key that has no letter, as WebDriver writes it.
pub mod key {
    pub const RIGHT: &str = "\u{E014}";
    pub const DOWN: &str = "\u{E015}";
    pub const ENTER: &str = "\u{E007}";
}

/// Whether there is a browser: Chromium and its driver on the path.
fn is_there() -> bool {
    let runs = |name: &str| {
        Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
    };
    runs("chromedriver") && runs("chromium")
}

impl Browser {
    /// Starts one that draws on the processor; none where this machine has none and does not have to.
    pub fn start() -> Option<Browser> {
        Browser::start_with(&["--disable-gpu"])
    }

    /// Starts one with more arguments.
    pub fn start_with(more: &[&str]) -> Option<Browser> {
        if !is_there() {
            assert!(
                std::env::var_os("SAGNAC_BROWSER").is_none_or(|browser| browser != "required"),
                "chromium and chromedriver are not on the path, and SAGNAC_BROWSER=required"
            );
            println!("NOT SHOWN HERE: chromium and chromedriver are not on the path");
            return None;
        }
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver runs");
        let lines = BufReader::new(driver.stdout.take().expect("its output is piped")).lines();
        let port = lines.map_while(Result::ok).find_map(|line| {
            let (_, port) = line.split_once("started successfully on port ")?;
            port.trim_end_matches('.').parse::<u16>().ok()
        });
        let base = format!("http://127.0.0.1:{}", port.expect("it says its port"));
        let profile = tempfile::tempdir().expect("a folder for a profile");
        let profile_folder = format!("--user-data-dir={}", profile.path().display());
        let arguments = [
            "--headless",
            "--no-sandbox",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--window-size=1280,900",
            profile_folder.as_str(),
        ];
        let arguments = [&arguments[..], more].concat();
        let asked = json!({ "capabilities": { "alwaysMatch": {
            "browserName": "chrome",
            "goog:chromeOptions": { "args": arguments },
            "goog:loggingPrefs": { "browser": "ALL" },
        } } });
        let agent = ureq::Agent::config_builder().http_status_as_error(false).build().new_agent();
        let mut browser = Browser { driver, session: base, agent, _profile: profile };
        let made = browser.post("/session", &asked);
        let id = made["sessionId"].as_str().unwrap_or_else(|| panic!("no session: {made}"));
        browser.session = format!("{}/session/{id}", browser.session);
        Some(browser)
    }

    /// What the driver answers.
    fn post(&self, path: &str, body: &Value) -> Value {
        let url = format!("{}{path}", self.session);
        let mut response = self.agent.post(&url).send_json(body).expect("the driver answers");
        let answer: Value = response.body_mut().read_json().expect("in JSON");
        assert!(response.status().is_success(), "{path}: {}", answer["value"]["message"]);
        answer["value"].clone()
    }

    /// Opens a page from its file, and waits until it has drawn itself; returns how long that took.
    pub fn open(&self, page: &Path) -> Duration {
        let started = Instant::now();
        self.begin(page);
        self.wait("return document.body.dataset.ready === 'true'");
        started.elapsed()
    }

    /// Opens a page from its file.
    pub fn begin(&self, page: &Path) {
        self.post("/url", &json!({ "url": format!("file://{}", page.display()) }));
    }

    /// What a script returns; `arguments[0]` is `argument` there.
    pub fn ask(&self, script: &str, argument: Value) -> Value {
        self.post("/execute/sync", &json!({ "script": script, "args": [argument] }))
    }

    /// The same as a text.
    pub fn text(&self, script: &str) -> String {
        let answer = self.ask(script, json!(null));
        answer.as_str().unwrap_or_else(|| panic!("{script}: {answer}")).to_owned()
    }

    /// The same as a number.
    pub fn number(&self, script: &str) -> f64 {
        let answer = self.ask(script, json!(null));
        answer.as_f64().unwrap_or_else(|| panic!("{script}: {answer}"))
    }

    /// Waits until a script says that it is so.
    pub fn wait(&self, script: &str) {
        let started = Instant::now();
        while self.ask(script, json!(null)) != json!(true) {
            assert!(started.elapsed() < PATIENCE, "after {PATIENCE:?} still not: {script}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The first element that a selector finds.
    fn element(&self, selector: &str) -> String {
        let found = self.post("/element", &json!({ "using": "css selector", "value": selector }));
        found[ELEMENT].as_str().expect("it has a name").to_owned()
    }

    /// Moves an element into view, at once where the page would glide, and clicks on its middle.
    pub fn click(&self, selector: &str) {
        let [left, top, width, height] = self.place(selector);
        self.click_at((left + 0.5 * width, top + 0.5 * height), 1);
    }

    /// Types into an element.
    pub fn press(&self, selector: &str, keys: &str) {
        let element = self.element(selector);
        self.post(&format!("/element/{element}/value"), &json!({ "text": keys }));
    }

    /// Moves an element into view; returns its left, top, width and height there, in px.
    pub fn place(&self, selector: &str) -> [f64; 4] {
        // The page hears that it was scrolled with the next frame.
        let script = "const e = document.querySelector(arguments[0]); \
            e.scrollIntoView({ block: 'center', behavior: 'instant' }); \
            const place = () => { const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height] }; \
            return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(place()))))";
        let place = self.ask(script, json!(selector));
        let part = |at: usize| place[at].as_f64().unwrap_or_else(|| panic!("{selector}: {place}"));
        [0, 1, 2, 3].map(part)
    }

    /// Moves the mouse along places in the window; the button is held from the first on where it is a `drag`.
    pub fn mouse(&self, places: &[(f64, f64)], drag: bool) {
        let moved = |&(x, y): &(f64, f64)| json!({ "type": "pointerMove", "duration": 0, "x": x.round(), "y": y.round() });
        let mut acts: Vec<Value> = places.iter().map(moved).collect();
        if drag {
            acts.insert(1, json!({ "type": "pointerDown", "button": 0 }));
            acts.push(json!({ "type": "pointerUp", "button": 0 }));
        }
        let pointer = json!({ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": acts });
        self.post("/actions", &json!({ "actions": [pointer] }));
    }

    /// Clicks twice, or once, at a place in the window.
    pub fn click_at(&self, (x, y): (f64, f64), times: usize) {
        let mut acts = vec![json!({ "type": "pointerMove", "duration": 0, "x": x.round(), "y": y.round() })];
        for _ in 0..times {
            acts.push(json!({ "type": "pointerDown", "button": 0 }));
            acts.push(json!({ "type": "pointerUp", "button": 0 }));
        }
        let pointer = json!({ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": acts });
        self.post("/actions", &json!({ "actions": [pointer] }));
    }

    /// A command of Chromium's own protocol.
    pub fn chromium(&self, command: &str, parameters: &Value) -> Value {
        self.post("/goog/cdp/execute", &json!({ "cmd": command, "params": parameters }))
    }

    /// What the page has written to the console since it was asked last.
    pub fn console(&self) -> Vec<String> {
        let entries = self.post("/se/log", &json!({ "type": "browser" }));
        let entries = entries.as_array().expect("a list").iter();
        entries.map(|entry| entry["message"].to_string()).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The browser ends with its session, the driver by itself.
        let _ = self.agent.delete(&self.session).call();
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
