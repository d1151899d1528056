// A file server and Chromium for tests of the site, without packages.

import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";

const TYPES = {
  ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".wasm": "application/wasm",
  ".png": "image/png", ".svg": "image/svg+xml", ".csv": "text/csv", ".toml": "text/plain; charset=utf-8",
};

export const wait = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Serves a folder on a free port of 127.0.0.1; `close` ends it with all its connections. */
export async function serve(folder) {
  const requests = [];
  const server = createServer((request, response) => {
    requests.push(request.url);
    const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    const file = join(folder, normalize(path.endsWith("/") ? `${path}index.html` : path));
    if (!statSync(file, { throwIfNoEntry: false })?.isFile()) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" }).end(readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const close = () => new Promise((resolve) => {
    server.close(resolve);
    server.closeAllConnections();
  });
  return { origin: `http://127.0.0.1:${server.address().port}`, close, requests };
}

/** A page of any browser, in which `evaluate` gives the value of an expression or a function. */
export class Tested {
  /** Waits until a condition holds in the page, and gives its value. */
  async until(condition, what, milliseconds = 20000) {
    const end = Date.now() + milliseconds;
    while (Date.now() < end) {
      const value = await this.evaluate(condition);
      if (value) return value;
      await wait(50);
    }
    throw new Error(`${what}: not within ${milliseconds / 1000} s`);
  }

  /** Drops files on the page: `[{name, bytes}]`. */
  drop(files) {
    const coded = files.map(({ name, bytes }) => ({ name, base64: Buffer.from(bytes).toString("base64") }));
    return this.evaluate((dropped) => {
      const dataTransfer = new DataTransfer();
      for (const { name, base64 } of dropped) dataTransfer.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], name));
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
    }, coded);
  }
}

/** Chromium with a fresh profile, driven over a pipe. */
export class Browser {
  static async start(more = []) {
    const executable = process.env.CHROMIUM ?? "chromium";
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), "sagnac-site-"));
    browser.process = spawn(executable, ["--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", `--user-data-dir=${browser.profile}`, ...more, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    browser.#listen();
    return browser;
  }

  #last = 0;
  #waiting = new Map();
  #pages = new Map();

  #listen() {
    let held = "";
    this.process.stdio[4].setEncoding("utf8").on("data", (text) => {
      const messages = (held + text).split("\0");
      held = messages.pop();
      messages.forEach((message) => this.#receive(JSON.parse(message)));
    });
  }

  #receive({ id, result, error, method, params, sessionId }) {
    if (id === undefined) {
      this.#pages.get(sessionId)?.received(method, params);
      return;
    }
    const { resolve, reject } = this.#waiting.get(id);
    this.#waiting.delete(id);
    if (error) reject(new Error(error.message));
    else resolve(result);
  }

  send(method, params = {}, sessionId = undefined) {
    this.#last += 1;
    const id = this.#last;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    });
  }

  /** A page with storage and caches of its own, as at a first visit. */
  async open(url) {
    const { browserContextId } = await this.send("Target.createBrowserContext");
    const { targetId } = await this.send("Target.createTarget", { url: "about:blank", browserContextId });
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    const page = new Page(this, sessionId, browserContextId);
    this.#pages.set(sessionId, page);
    await Promise.all(["Page.enable", "Runtime.enable", "Network.enable", "Log.enable"].map((method) => page.send(method)));
    await page.viewport(1280, 900);
    await page.go(url);
    return page;
  }

  async close() {
    const ended = new Promise((resolve) => this.process.once("exit", resolve));
    await this.send("Browser.close").catch(() => {});
    await Promise.race([ended, wait(5000)]);
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

class Page extends Tested {
  requests = [];
  /** Messages of the console that are errors, and exceptions that nobody caught. */
  faults = [];
  #loaded = () => {};

  constructor(browser, sessionId, context) {
    super();
    Object.assign(this, { browser, sessionId, context });
  }

  received(method, params) {
    if (method === "Network.requestWillBeSent") this.requests.push(params.request.url);
    if (method === "Page.loadEventFired") this.#loaded();
    if (method === "Runtime.exceptionThrown") this.faults.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === "Log.entryAdded" && params.entry.level === "error") this.faults.push(`${params.entry.text} ${params.entry.url ?? ""}`);
  }

  send(method, params) {
    return this.browser.send(method, params, this.sessionId);
  }

  async #load(act) {
    const loaded = new Promise((resolve) => {
      this.#loaded = resolve;
    });
    await act();
    await Promise.race([loaded, wait(15000).then(() => Promise.reject(new Error("the page did not load in 15 s")))]);
  }

  /** Loads an address; of one that differs in its fragment only, the page stays. */
  async go(url) {
    await this.#load(() => this.send("Page.navigate", { url }));
  }

  reload() {
    return this.#load(() => this.send("Page.reload"));
  }

  /** The value of an expression, or of what a function with arguments that JSON can hold returns in the page. */
  async evaluate(code, ...values) {
    const expression = typeof code === "function" ? `(${code})(...${JSON.stringify(values)})` : code;
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async press(key, modifiers = 0) {
    const codes = { Tab: 9, Enter: 13, " ": 32, ArrowRight: 39 };
    const text = { Enter: "\r", " ": " " }[key];
    const event = { key, code: key === " " ? "Space" : key, windowsVirtualKeyCode: codes[key], modifiers };
    await this.send("Input.dispatchKeyEvent", { type: "keyDown", text, ...event });
    await this.send("Input.dispatchKeyEvent", { type: "keyUp", ...event });
  }

  viewport(width, height, isMobile = false) {
    return this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: isMobile });
  }

  scheme(value) {
    return this.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value }] });
  }

  async screenshot(file, isWhole = false) {
    const { data } = await this.send("Page.captureScreenshot", { format: "png", captureBeyondViewport: isWhole });
    writeFileSync(file, Buffer.from(data, "base64"));
  }

  /** Roles and names of what can be used, as screen readers get them, without the content of reports. */
  async controls() {
    await this.send("Accessibility.enable");
    const { nodes } = await this.send("Accessibility.getFullAXTree");
    const roles = ["button", "link", "textbox", "slider", "combobox", "spinbutton", "checkbox", "Iframe", "DisclosureTriangle", "progressbar"];
    return nodes.filter((node) => !node.ignored && roles.includes(node.role?.value)).map((node) => ({ role: node.role.value, name: node.name?.value ?? "" }));
  }

  /** Addresses of requests to another host than that of the site. */
  strangers(origin) {
    return this.requests.filter((url) => /^(https?|wss?):/.test(url) && new URL(url).origin !== origin);
  }

  close() {
    return this.browser.send("Target.disposeBrowserContext", { browserContextId: this.context });
  }
}
