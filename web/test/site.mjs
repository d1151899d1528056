// node web/test/site.mjs FOLDER [NAME…]: tests of the built site in Chromium, all or those whose names contain one of NAME.

import { resolve } from "node:path";
import { Browser, serve, wait } from "./browser.mjs";
import { STATES, bare, goTo, hasReport, isIdle, isShown, linkOf, survey } from "./looks.mjs";

const STUDY = `title = "A gap in a vibration"
question = "Which filler is best?"
kind = "gap-fill"
trials = 5000

[gyro]
tick = "5 ms"
tick_noise = { three_sigma = "1.6 arcsec" }

[motion]
amplitude = "12000 arcsec/s"
frequency = "20 Hz"

[switching]
gap_ticks = 3
fillers = ["const", "quadratic"]

[[sweep]]
key = "switching.gap_ticks"
list = [1, 2, 3]
`;

/** Whether the service worker has all files and serves the page. */
const IS_KEPT = `navigator.serviceWorker.ready.then((registration) => registration.active?.state === "activated" && Boolean(navigator.serviceWorker.controller))`;

function check(condition, why) {
  if (!condition) throw new Error(why);
}

/** Each test gets a page of its own at the address of the site. */
const tests = {
  async every_view_is_reached_by_keyboard(page) {
    for (const [label, view] of [["Studies", "studies"], ["Convert units", "convert"], ["Verify", "verify"], ["Analyze a log", "log"]]) {
      await tabTo(page, label);
      await page.press("Enter");
      await page.until(isShown(view), `view ${view} after Enter on ${label}`);
    }
    await tabTo(page, "Studies");
    await page.press("Enter");
    await page.until(`document.querySelector("#gallery a")`, "the gallery");
    await tabTo(page, await page.evaluate(`document.querySelector("#gallery h2").textContent`));
    await page.press("Enter");
    await page.until(isShown("study"), "the view of a study");
    await page.until(`document.querySelector("#sliders input")`, "sliders");
    const name = await page.evaluate(`document.querySelector("#sliders label").textContent`);
    const before = await page.evaluate(`document.getElementById("study-text").value`);
    await tabTo(page, name);
    await page.press("ArrowRight");
    check(before !== (await page.evaluate(`document.getElementById("study-text").value`)), "an arrow key on a slider did not change the text");
  },

  async every_state_is_legible_in_light_and_dark_and_has_no_barriers(page) {
    for (const [state, enter] of Object.entries(STATES)) {
      await enter(page);
      await named(page, state);
      const ratios = [];
      for (const scheme of ["light", "dark"]) {
        await page.scheme(scheme);
        const { contrast, faint, barriers } = await page.evaluate(survey);
        check(faint.length === 0, `${state}, ${scheme}, contrast of ${faint.slice(0, 5).join("; ")}`);
        check(barriers.length === 0, `${state}, ${barriers.slice(0, 5).join("; ")}`);
        ratios.push(`${contrast.toFixed(2)} in ${scheme}`);
      }
      console.log(`   ${state}: least contrast ${ratios.join(", ")}`);
    }
  },

  async nothing_is_broken_or_scrolls_sideways_on_a_phone(page) {
    await page.viewport(390, 844, true);
    await page.reload();
    for (const [state, enter] of Object.entries(STATES)) {
      await enter(page);
      const { broken, barriers } = await page.evaluate(survey);
      check(broken.length === 0, `${state}, broken: ${broken.slice(0, 5).join("; ")}`);
      check(barriers.length === 0, `${state}, ${barriers.slice(0, 5).join("; ")}`);
    }
  },

  async charts_of_reports_are_drawn_under_the_policy(page) {
    await page.evaluate(`document.getElementById("example").click()`);
    await page.until(`document.querySelector("#log-report iframe:not(.incoming)")?.contentDocument.body.dataset.ready === "true"`, "the script of the report");
    const policed = await page.evaluate(() => {
      const frame = document.querySelector("#log-report iframe").contentWindow;
      const script = frame.document.createElement("script");
      script.textContent = "window.strange = true";
      frame.document.body.append(script);
      try {
        frame.eval("1");
        return "eval runs";
      } catch {
        return frame.strange ? "a strange script runs" : "";
      }
    });
    check(policed === "", policed);
    // The browser reports what it did not run.
    page.faults.length = 0;
  },

  async nothing_is_asked_of_any_server_after_loading(page, { origin, requests }) {
    await page.until(IS_KEPT, "the service worker");
    const before = requests.length;
    await page.evaluate(`document.getElementById("example").click()`);
    await page.until(hasReport("log"), "the report of the example");
    await goTo(page, linkOf(STUDY));
    await page.until(hasReport("study"), "the report of a study");
    for (const view of ["studies", "convert", "verify"]) {
      await goTo(page, view);
      await page.until(isShown(view), `view ${view}`);
    }
    // The browser itself asks whether the service worker is the newest.
    const asked = requests.slice(before).filter((url) => url !== "/sw.js");
    check(asked.length === 0, `the server was asked for ${asked.join(", ")}`);
    const strangers = page.strangers(origin);
    check(strangers.length === 0, `requests to ${strangers.join(", ")}`);
  },

  async the_site_works_offline_after_the_first_visit(page, site) {
    await page.until(IS_KEPT, "the service worker");
    await site.close();
    await page.reload();
    await page.evaluate(`document.getElementById("example").click()`);
    await page.until(hasReport("log"), "the report of the example without a server");
    await goTo(page, "studies");
    await page.until(`document.querySelectorAll("#gallery article").length > 0`, "the gallery without a server");
  },

  async a_log_without_a_rate_opens_the_form_at_it(page) {
    await page.drop([bare]);
    await page.until(`!document.getElementById("log-error").hidden`, "the message");
    const focused = await page.evaluate(`document.getElementById("log-options").open && document.activeElement.name`);
    check(focused === "rate", `the focus is in ${focused}`);
    await page.evaluate(`document.activeElement.value = "100 Hz"`);
    await page.press("Enter");
    await page.until(hasReport("log"), "the report after the rate was given");
    await page.until(`document.getElementById("log-error").hidden`, "the message to go");
  },

  async work_is_stopped_while_the_page_stays_responsive(page) {
    await goTo(page, linkOf(STUDY.replace("trials = 5000", "trials = 1_000_000_000")));
    await page.until(`!document.querySelector("#study-actions button").hidden`, "the button that runs all trials");
    await page.until(isIdle("study"), "the end of the live run");
    await stopped(page, "study", `document.querySelector("#study-actions button").click()`);
    check(await page.evaluate(`!document.querySelector("#study-actions button:nth-of-type(2)").hidden`), "what was stopped cannot be run again");
    const digest = `document.querySelector("#study-ran code")?.textContent`;
    const before = await page.evaluate(digest);
    await page.evaluate(`Object.assign(document.querySelector("#sliders input"), { value: 100 }).dispatchEvent(new Event("input"))`);
    await page.until(`${digest} !== "${before}" && ${isIdle("study")}`, "another answer after the stop");
    await goTo(page, "#log");
    await page.evaluate(`globalThis.longLog = new File(["rate [deg/h]\\n", ...Array(100).fill("0.123\\n0.456\\n0.789\\n".repeat(60000))], "long.csv")`);
    await stopped(page, "log", () => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(globalThis.longLog);
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
    });
    await page.evaluate(`document.getElementById("example").click()`);
    await page.until(hasReport("log"), "the report of the example after the stop");
  },

  async one_of_several_columns_is_simulated_and_a_picture_costs_no_analysis(page) {
    const rows = Array.from({ length: 4000 }, (_, at) => `${at * 10},${[1, 2, 3].map((seed) => Math.sin(at * at * seed)).join(",")},${24 + at / 4000}`);
    const log = { name: "imu.csv", bytes: Buffer.from(["t_ms,gyro_x,gyro_y,gyro_z,temp", ...rows].join("\n")) };
    await page.drop([log]);
    await page.until(`document.activeElement === document.getElementById("log-form").elements.unit`, "the unit to be asked for");
    await page.evaluate(`document.activeElement.value = "deg/s"; document.getElementById("log-form").requestSubmit()`);
    await page.until(hasReport("log"), "the report of three columns");
    await page.until(isIdle("log"), "the end of the simulation");
    await page.drop([{ name: "photo.png", bytes: Buffer.from("\x89PNG\r\n\x1a\n", "latin1") }]);
    await page.until(`document.getElementById("log-error").textContent.includes("a picture (PNG)")`, "a picture to be called so");
    await page.evaluate(`document.querySelector("#log-choice button").click()`);
    await page.until(`${hasReport("log")} && document.querySelector("#log-facts").textContent.includes("gyro_z")`, "the log before");
    await page.evaluate(`[...document.querySelectorAll("#log-actions button")].find((each) => each.textContent === "Simulate this gyro").click()`);
    await page.evaluate(`document.querySelectorAll("#log-choice button")[1].click()`);
    await page.until(`document.getElementById("study-text").value.includes("Records like gyro_y of imu.csv")`, "the study of the second column");
  },

  async mistakes_are_shown_while_typing(page) {
    await goTo(page, linkOf(STUDY));
    await page.until(hasReport("study"), "the report of a study");
    const type = (from, to) => page.evaluate((before, after) => {
      const text = document.getElementById("study-text");
      text.value = text.value.replace(before, after);
      text.dispatchEvent(new Event("input"));
    }, from, to);
    await type("20 Hz", "20 Hertz");
    await page.until(`document.getElementById("study-error").textContent.includes("Hertz")`, "the message with the line");
    check(await page.evaluate(`document.querySelector("#sliders input").disabled`), "sliders change a text that cannot be read");
    await type("20 Hertz", "21 Hz");
    await page.until(`document.getElementById("study-error").hidden`, "the message to go");
    await page.until(`location.hash.startsWith("#s=") && location.hash !== ${JSON.stringify(linkOf(STUDY))}`, "the edited study in the address");
  },

  async sweeps_and_sliders_change_their_places_in_the_text(page) {
    await goTo(page, linkOf(STUDY));
    await page.until(`document.querySelector("#sweeps textarea")`, "the field of a sweep");
    const set = (selector, value) => page.evaluate((found, written) => {
      const input = document.querySelector(found);
      input.focus();
      input.value = written;
      input.dispatchEvent(new Event("input"));
    }, selector, value);
    await set("#sweeps textarea", "[1, 2, 3, 4, 5]");
    await page.until(`document.querySelector("#sweeps label").textContent.endsWith("5 values")`, "the number of values of the sweep");
    await set("#sliders input", "300");
    await set("#sliders input", "350");
    await page.until(`document.getElementById("study-ran").textContent && !document.querySelector("#sweeps textarea").disabled`, "the sweep to be read again");
    const text = await page.evaluate(`document.getElementById("study-text").value`);
    const expected = STUDY.replace("[1, 2, 3]", "[1, 2, 3, 4, 5]").replace(/tick = "[^"]*"/, /tick = "[^"]*"/.exec(text)[0]);
    check(text === expected && !text.includes('"5 ms"'), `the text became ${JSON.stringify(text)}`);
  },

  async damaged_files_give_a_message_and_leave_the_page_alive(page) {
    const noise = Buffer.from(Array.from({ length: 4096 }, (_, at) => (at * at * 37 + at) & 255));
    const begins = { "a.npy": "\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'shape': (9999999999,), }", "a.npz": "PK\x03\x04\xff\xff", "a.mat": "MATLAB 5.0 MAT-file", "a.h5": "\x89HDF\r\n\x1a\n", "a.csv": "\xff\xfe\x00" };
    for (const [name, begin] of Object.entries(begins)) {
      await page.drop([{ name, bytes: Buffer.concat([Buffer.from(begin, "latin1"), noise]) }]);
      await page.until(`document.getElementById("log-name").textContent === "${name}" && document.getElementById("log-error").textContent`, `a message on ${name}`);
    }
    await page.drop([{ name: "empty.csv", bytes: Buffer.alloc(0) }]);
    await page.until(`document.getElementById("log-name").textContent === "empty.csv" && document.getElementById("log-error").textContent`, "a message on an empty file");
    await page.evaluate(`document.getElementById("example").click()`);
    await page.until(hasReport("log"), "the report of the example afterwards");
  },

  async results_depend_neither_on_workers_nor_on_vectors(page, { origin }) {
    const results = [];
    for (const address of [origin, `${origin}/?portable`]) {
      await page.go(address);
      for (const shares of [1, 2, 5]) results.push(await page.evaluate(outcome, STUDY, 5000, shares));
    }
    const different = results.filter((result) => result !== results[0]);
    check(different.length === 0, `digest and report are ${results.join(", ")}`);
  },

  async a_link_restores_its_study(page) {
    await goTo(page, linkOf(STUDY));
    await page.until(isShown("study"), "the view of a study");
    await page.until(`document.getElementById("study-text").value`, "the text of the study");
    const text = await page.evaluate(`document.getElementById("study-text").value`);
    check(text === STUDY, `the text became ${JSON.stringify(text.slice(0, 80))}…`);
    await goTo(page, linkOf(STUDY).slice(0, 40));
    await page.until(`!document.getElementById("trouble").hidden`, "a message on a link that was cut off");
  },
};

/** Runs in the page: the digest of the tables of a study and the SHA-256 of its report, with so many shares. */
async function outcome(text, trials, shares) {
  const { engine } = await import("/engine.js");
  engine.shares = shares;
  const study = { text, name: "study.toml" };
  const { rows } = await engine.sample(study, { trials });
  const { reply, blobs } = await engine.ask({ call: "outcome", ...study, trials, complete: true }, { blobs: rows });
  const hash = await crypto.subtle.digest("SHA-256", blobs[0]);
  return [reply.digest, ...Array.from(new Uint8Array(hash).slice(0, 8), (byte) => byte.toString(16).padStart(2, "0"))].join("");
}

/** Begins work in a view and stops it after a while, in which a timer of the page must go on, by the button of its progress. */
async function stopped(page, view, begin) {
  await page.evaluate(() => {
    globalThis.longest = 0;
    let last = performance.now();
    globalThis.ticking = setInterval(() => {
      globalThis.longest = Math.max(globalThis.longest, performance.now() - last);
      last = performance.now();
    }, 10);
  });
  await page.evaluate(begin);
  await wait(400);
  const state = `document.getElementById("${view}-progress").dataset.state`;
  check((await page.evaluate(state)) === "busy", `the work in ${view} ended before it was stopped`);
  await page.evaluate(`document.querySelector("#${view}-progress button").click()`);
  await wait(100);
  const [longest, after, isMessage] = await page.evaluate(`clearInterval(ticking), [longest, ${state}, !document.getElementById("${view}-error").hidden]`);
  check(after === "stopped" && !isMessage, `after the stop the progress in ${view} is ${after}, ${isMessage ? "with" : "without"} a message`);
  check(longest < 200, `the page did not answer for ${Math.round(longest)} ms during the work in ${view}`);
  console.log(`   ${view}: longest gap ${Math.round(longest)} ms`);
}

/** Presses Tab until what has the focus is called so. */
async function tabTo(page, name) {
  for (let presses = 0; presses < 120; presses += 1) {
    await page.press("Tab");
    const focused = await page.evaluate(`(document.activeElement.labels?.[0] ?? document.activeElement).textContent.trim()`);
    if (focused.startsWith(name)) return;
  }
  throw new Error(`120 presses of Tab did not reach ${name}`);
}

async function named(page, where) {
  const nameless = (await page.controls()).filter(({ name }) => !name.trim());
  check(nameless.length === 0, `${where}: no name for ${nameless.map(({ role }) => role).join(", ")}`);
}

/** Fails after the time in s that no test takes. */
async function tooLong(most = 240) {
  await wait(1000 * most);
  throw new Error(`it did not end within ${most} s`);
}

async function run(browser, folder, name) {
  const site = await serve(folder);
  const page = await browser.open(site.origin);
  try {
    await Promise.race([tests[name](page, site), tooLong()]);
    check(page.faults.length === 0, `errors in the console: ${page.faults.join("; ")}`);
    console.log(`ok ${name}`);
    return true;
  } catch (error) {
    console.log(`FAIL ${name}: ${error.message}`);
    return false;
  } finally {
    await page.close();
    await site.close();
  }
}

const [folder, ...wanted] = process.argv.slice(2);
const names = Object.keys(tests).filter((name) => wanted.length === 0 || wanted.some((part) => name.includes(part)));
const browser = await Browser.start();
let failed = 0;
for (const name of names) if (!(await run(browser, resolve(folder), name))) failed += 1;
await browser.close();
process.exitCode = failed > 0 ? 1 : 0;
// Timers of tests that ended are still running.
process.exit();
