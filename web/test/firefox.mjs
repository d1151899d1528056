// node --experimental-websocket web/test/firefox.mjs SITE: the site in Firefox (or $FIREFOX), driven by WebDriver BiDi.

import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { Tested, serve, wait } from "./browser.mjs";
import { agrees, digestOfKernels, kernels, pointsOf, studies } from "./digests.mjs";
import { STATES, hasReport, survey } from "./looks.mjs";

/** Firefox with a fresh profile, and one page in it. */
class Firefox extends Tested {
  /** Errors of the console. */
  faults = [];
  #last = 0;
  #waiting = new Map();

  static async start() {
    const firefox = new Firefox();
    firefox.profile = mkdtempSync(join(tmpdir(), "sagnac-firefox-"));
    firefox.process = spawn(process.env.FIREFOX ?? "firefox", ["--headless", "--no-remote", "--profile", firefox.profile, "--remote-debugging-port=0"], { stdio: ["ignore", "ignore", "pipe"] });
    const address = await new Promise((found, failed) => {
      let said = "";
      firefox.process.on("error", failed).on("exit", (code) => failed(new Error(`Firefox ended with ${code}: ${said}`)));
      firefox.process.stderr.setEncoding("utf8").on("data", (text) => {
        said += text;
        const [, url] = /WebDriver BiDi listening on (ws:\S+)/.exec(said) ?? [];
        if (url) found(url);
      });
    });
    firefox.socket = new WebSocket(`${address}/session`);
    firefox.socket.onmessage = ({ data }) => firefox.#receive(JSON.parse(data));
    await new Promise((opened, failed) => Object.assign(firefox.socket, { onopen: opened, onerror: ({ message }) => failed(new Error(message)) }));
    await firefox.send("session.new", { capabilities: {} });
    await firefox.send("session.subscribe", { events: ["log.entryAdded"] });
    const { contexts } = await firefox.send("browsingContext.getTree", {});
    firefox.context = contexts[0].context;
    return firefox;
  }

  #receive({ id, type, result, message, method, params }) {
    if (method === "log.entryAdded" && params.level === "error") this.faults.push(params.text);
    const { done, failed } = this.#waiting.get(id) ?? {};
    this.#waiting.delete(id);
    if (type === "error") failed?.(new Error(message));
    else done?.(result);
  }

  send(method, params) {
    this.#last += 1;
    return new Promise((done, failed) => {
      this.#waiting.set(this.#last, { done, failed });
      this.socket.send(JSON.stringify({ id: this.#last, method, params }));
    });
  }

  go(url) {
    return this.send("browsingContext.navigate", { context: this.context, url, wait: "complete" });
  }

  /** The value of an expression, or of what a function with arguments that JSON can hold returns in the page. */
  async evaluate(code, ...values) {
    const called = typeof code === "function" ? `(${code})(...${JSON.stringify(values)})` : code;
    const { result, exceptionDetails } = await this.send("script.callFunction", {
      functionDeclaration: `async () => JSON.stringify(await ${called})`, awaitPromise: true, target: { context: this.context },
    });
    if (exceptionDetails) throw new Error(exceptionDetails.text);
    return result.value === undefined ? undefined : JSON.parse(result.value);
  }

  async close() {
    const ended = new Promise((done) => this.process.once("exit", done));
    this.process.kill();
    await Promise.race([ended, wait(5000)]);
    rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
  }
}

const folder = resolve(process.argv[2]);
let failed = 0;
const expect = (name, found, expected) => {
  if (!agrees(`Firefox: ${name}`, found, expected)) failed += 1;
};
const site = await serve(folder);
const firefox = await Firefox.start();
try {
  await firefox.go(site.origin);
  const about = await firefox.until(`document.getElementById("about").textContent`, "the line about the program");
  expect("the page names the width of its vectors", about.includes("SIMD128"), true);
  expect("kernels", await firefox.evaluate(digestOfKernels), `${kernels()} by SIMD128`);
  const { study: { trials, ...study }, expected } = studies(JSON.parse(readFileSync(join(folder, "gallery.json")))).find(({ name }) => name === "smoke");
  expect("smoke", await firefox.evaluate(pointsOf, study, trials, 2), expected);
  // One line says who computed, and why not the GPU where it failed.
  await firefox.evaluate(`void (location.hash = "study=smoke")`);
  const ran = await firefox.until(`document.getElementById("study-ran").textContent`, "the line about a study");
  expect(`one line says who computed: ${ran}`, /^(\d+ workers?, SIMD128(; not on WebGPU: .+)?|WebGPU on .+) · \d/.test(ran), true);
  expect("the service worker keeps the site", await firefox.until(`navigator.serviceWorker.ready.then(({ active }) => active?.state === "activated")`, "the service worker"), true);
  await firefox.send("browsingContext.setViewport", { context: firefox.context, viewport: { width: 390, height: 844 } });
  await firefox.go(site.origin);
  for (const [state, enter] of Object.entries(STATES)) {
    await enter(firefox);
    if (state === "log") {
      const headline = await firefox.evaluate(`${hasReport("log")}.contentDocument.querySelector("#answer .headline").textContent`);
      expect("the example has a headline", /^N = [\d.]+ °\/√h/.test(headline), true);
    }
    const { faint, barriers, broken } = await firefox.evaluate(survey);
    expect(`${state} on a phone`, [...faint, ...barriers, ...broken].join("; "), "");
  }
  expect("errors in the console", firefox.faults.join("; "), "");
} catch (error) {
  console.log(`FAIL Firefox: ${error.message}`);
  failed += 1;
} finally {
  await firefox.close();
  await site.close();
}
process.exit(failed > 0 ? 1 : 0);
