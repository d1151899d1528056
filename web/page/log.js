// The view of a log: what was read, its noise, and what follows from the noise.

import { Progress, announce, button, byId, copy, element, grouped, note, quoted, seconds, showError, showFiles } from "./elements.js";
import { engine, isStopped } from "./engine.js";
import { Report } from "./report.js";

/** Larger files do not fit into the memory of the module with what is computed from them. */
const MOST_BYTES = 400e6;

/** The example has no time stamps. */
const EXAMPLE_OPTIONS = { rate: "1 Hz" };

/** Number of simulated records after which there are first intervals. */
const FIRST_RECORDS = 200;

const ANALYSES = [
  { id: "allan", label: "Noise", doing: "Analyzing", command: "allan" },
  { id: "model", label: "Filter model", doing: "Fitting a filter model", command: "model --overbound --write all" },
  { id: "navigate", label: "Position error", doing: "Simulating a navigator", command: "allan --navigate 1h" },
];

export class LogView {
  /** `openStudy(text, name)` shows a study that was made from a log. */
  constructor(openStudy) {
    this.openStudy = openStudy;
    this.file = null;
    this.other = null;
    /** The log that was read before this one, with its options, if any. */
    this.before = null;
    /** The options with which the log was read. */
    this.options = {};
    /** Names of the columns that were read. */
    this.columns = [];
    /** Number of records that are simulated for the intervals; 0 where that takes too long. */
    this.records = 0;
    this.isComparing = false;
    this.hint = byId("choose-hint").textContent;
    this.form = byId("log-form");
    this.report = new Report(byId("log-report"));
    this.progress = new Progress(byId("log-progress"));
    this.#buttons();
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#read();
    });
    byId("choose").addEventListener("click", () => this.choose());
    byId("example").addEventListener("click", () => this.example());
    byId("file").addEventListener("change", ({ target }) => {
      if (target.files[0]) this.open(target.files[0]);
      // The same file may be chosen again.
      target.value = "";
    });
  }

  choose() {
    byId("file").click();
  }

  async example() {
    const response = await fetch("example/gyro_at_rest.csv");
    if (!response.ok) throw new Error(`The example could not be loaded (${response.status})`);
    this.open(new File([await response.blob()], "gyro_at_rest.csv"), EXAMPLE_OPTIONS);
  }

  /** Opens a log, or the second of a comparison. */
  open(file, options = {}) {
    if (file.size > MOST_BYTES) return this.#refuse(file);
    if (this.isComparing) return this.#compare(file);
    this.#keep();
    this.file = file;
    this.other = null;
    this.form.reset();
    for (const [name, value] of Object.entries(options)) this.form.elements[name].value = value;
    this.#name(file.name);
    return this.#read();
  }

  /** Opens two logs that were dropped together, and compares them. */
  async openBoth(first, second) {
    await this.open(first);
    if (this.file === first) await this.#compare(second);
  }

  /** Remembers the log that was read, when another file takes its place. */
  #keep() {
    if (this.columns.length > 0) this.before = { file: this.file, options: this.options };
    this.columns = [];
  }

  #name(text) {
    byId("log-work").hidden = false;
    for (const part of ["log-introduction", "log-promise"]) byId(part).hidden = true;
    byId("drop").classList.add("compact");
    byId("log-name").textContent = text;
    byId("log-name").scrollIntoView({ block: "nearest" });
  }

  #refuse(file) {
    this.progress.abort();
    this.#name(file.name);
    this.#clear();
    this.#keep();
    this.file = null;
    this.#comparing(false);
    byId("log-actions").hidden = true;
    this.#offerBefore();
    showError(byId("log-error"), new Error(`${file.name} has ${Math.round(file.size / 1e6)} MB; this page reads up to ${MOST_BYTES / 1e6} MB.\nThe program reads it in a terminal:\n\n    sagnac allan ${quoted(file.name)}`));
  }

  #clear() {
    byId("log-facts").hidden = true;
    byId("log-notes").replaceChildren();
    byId("log-ran").textContent = "";
    byId("log-files").replaceChildren();
    byId("log-choice").replaceChildren();
    this.report.clear();
    showError(byId("log-error"), null);
  }


  async #bytes(file) {
    return new Uint8Array(await file.arrayBuffer());
  }

  /** Reads the log, says what was read or what is missing, and analyzes its noise. */
  async #read() {
    if (!this.file) return;
    const { file } = this;
    this.#clear();
    this.#comparing(false);
    this.columns = [];
    // What is edited later counts when the log is read again.
    this.options = Object.fromEntries(new FormData(this.form));
    byId("log-actions").hidden = true;
    const signal = this.progress.begin(`Reading ${file.name}`);
    try {
      const { reply } = await engine.ask({ call: "read", name: file.name, options: this.options }, { blobs: [await this.#bytes(file)], isGiven: true, signal });
      this.#facts(reply);
      this.records = reply.records;
      this.columns = reply.columns.map(({ name }) => name);
      byId("log-options").open = false;
      byId("log-actions").hidden = false;
    } catch (error) {
      this.#failed(error);
      if (error.kind === "record" || error.kind === "usage") this.#askForOptions(error);
      if (!signal.aborted) this.#offerBefore();
      return;
    } finally {
      this.progress.end(signal);
    }
    await this.#analyze(ANALYSES[0]);
  }

  #failed(error) {
    if (!isStopped(error)) showError(byId("log-error"), error);
  }

  /** A file that was no log does not cost the analysis of the one before. */
  #offerBefore() {
    const { before } = this;
    if (!before) return;
    byId("log-choice").replaceChildren(button(`Back to ${before.file.name}`, "Analyze the log before again, with its options", () => this.open(before.file, before.options)));
  }

  /** Opens the form at the option that the message asks for first. */
  #askForOptions({ message }) {
    byId("log-options").open = true;
    const named = /no column is called|choose|columns/.test(message.split("\n")[0]) ? "column" : /\b(unit|rate|data|column|temperature|time_unit|time|binary): /.exec(message)?.[1] ?? "unit";
    const field = this.form.elements[named.replace("_", "-")];
    field.focus();
    field.select?.();
  }

  #facts({ samples, step_s: step, rate, data, points, taus, columns, notes }) {
    const facts = byId("log-facts");
    const shown = columns.map(({ name, unit }) => (unit ? `${name} in ${unit}` : name)).join(", ");
    const read = points
      ? [["Curve", `${points} points`], ["Averaging times", taus]]
      : [["Samples", grouped(samples)], ["Rate", rate], ["Length", length(samples * step)], ["Numbers", DATA[data]]];
    facts.replaceChildren(...[...read, ["Columns", shown]]
      .flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
    facts.hidden = false;
    byId("log-notes").replaceChildren(...notes.map(note));
  }

  #buttons() {
    byId("log-actions").replaceChildren(
      ...ANALYSES.map((analysis) => button(analysis.label, `sagnac ${analysis.command}`, () => this.#analyze(analysis), { "aria-pressed": "false", "data-analysis": analysis.id })),
      button("Compare with another log", "Choose or drop a second log", () => this.#startComparison(), { "aria-pressed": "false", "data-analysis": "compare" }),
      button("Simulate this gyro", "Open a study with the noise of this log", () => this.#chooseColumn()),
      button("Copy command", "Copy the command that repeats this in a terminal", ({ currentTarget }) => this.#copyCommand(currentTarget)));
  }

  #pressed(id) {
    this.shown = id;
    byId("log-actions").querySelectorAll("[data-analysis]").forEach((each) => each.setAttribute("aria-pressed", String(each.dataset.analysis === id)));
  }

  #copyCommand(from) {
    copy(this.#command(), from);
  }

  #command() {
    const options = Object.entries(this.options).filter(([, value]) => value).map(([name, value]) => ` --${name} ${quoted(value)}`).join("");
    const name = quoted(this.file.name);
    if (this.shown === "compare") return `sagnac compare ${name} ${quoted(this.other.name)}${options}`;
    return `sagnac ${ANALYSES.find(({ id }) => id === this.shown).command.replace(/^\w+/, `$& ${name}`)}${options}`;
  }

  /** Intervals in closed form first; those of the first simulated records take their place when they are ready, and then those of all. */
  async #analyze({ id, doing }) {
    this.#comparing(false);
    this.#pressed(id);
    const { file } = this;
    const request = { call: id, name: file.name, simulated: 0 };
    const first = id === "allan" && this.records > 0 ? "First estimates, with intervals in closed form. " : "";
    let isShown = await this.#show(`${doing} ${file.name}`, request, [file], first);
    if (id !== "allan") return;
    const parts = [];
    for (const [from, to] of [[0, FIRST_RECORDS], [FIRST_RECORDS, this.records]]) {
      if (!isShown || this.shown !== id || from >= this.records) return;
      const made = await this.#simulate(file, from, to);
      if (!made) return;
      parts.push(...made);
      isShown = await this.#show("Fitting simulated records", { ...request, simulated: to, parts: parts.length }, [file], `Intervals from ${grouped(to)} simulated records. `, parts.flat());
    }
  }

  /** Simulates records from one number to another on all workers; null if that failed, was stopped, or nothing can be simulated. */
  async #simulate(file, from, to) {
    const signal = this.progress.begin(`Simulating ${grouped(this.records)} records for the intervals`);
    try {
      const made = await engine.simulate({ name: file.name, options: this.options, from, to }, {
        blobs: [await this.#bytes(file)],
        signal,
        progress: (done, all) => this.progress.set(from + (to - from) * done / all, this.records),
      });
      if (made.flat().length > 0) return made;
      byId("log-ran").textContent = "Intervals in closed form: the noise cannot be simulated.";
      return null;
    } catch (error) {
      this.#failed(error);
      return null;
    } finally {
      this.progress.end(signal);
    }
  }

  /** Shows what a request answers about some files, after which it takes those `more` bytes; false if it failed or was stopped. */
  async #show(text, request, files, remark, more = []) {
    showError(byId("log-error"), null);
    const signal = this.progress.begin(text);
    try {
      // They are given away, and further records need them again.
      const blobs = [...await Promise.all(files.map((file) => this.#bytes(file))), ...more.map((bytes) => bytes.slice())];
      const begun = performance.now();
      const { reply, blobs: made } = await engine.ask({ ...request, options: this.options }, { blobs, isGiven: true, signal, progress: (...part) => this.progress.set(...part) });
      const took = performance.now() - begun;
      await this.report.show(made[0], files.map(({ name }) => name).join(" and "));
      if (signal.aborted) return false;
      byId("log-ran").textContent = `${remark}Computed in this browser in ${seconds(took)}.`;
      byId("log-notes").replaceChildren(...(reply.notes ?? []).map(note));
      const saved = reply.files.map((name, at) => ({ name, bytes: made[at + 1] }));
      showFiles(byId("log-files"), [{ name: "report.html", bytes: made[0] }, ...saved]);
      announce(reply.headline);
      return true;
    } catch (error) {
      this.#failed(error);
      return false;
    } finally {
      this.progress.end(signal);
    }
  }

  #startComparison() {
    this.#comparing(!this.isComparing);
    if (this.isComparing) this.choose();
  }

  #comparing(isComparing) {
    this.isComparing = isComparing;
    byId("drop").classList.toggle("second", isComparing);
    byId("choose-hint").textContent = isComparing ? `or drop the log that is compared with ${this.file.name}.` : this.hint;
  }

  async #compare(file) {
    this.#comparing(false);
    if (this.file.size + file.size > MOST_BYTES) {
      showError(byId("log-error"), new Error(`Both logs together have more than ${MOST_BYTES / 1e6} MB.\nThe program compares them in a terminal:\n\n    sagnac compare ${quoted(this.file.name)} ${quoted(file.name)}`));
      return;
    }
    this.other = file;
    this.#pressed("compare");
    await this.#show(`Comparing ${this.file.name} with ${file.name}`, { call: "compare", names: [this.file.name, file.name] }, [this.file, file], "");
  }

  /** A study simulates one gyro: of several columns, the reader chooses one. */
  #chooseColumn() {
    if (this.columns.length === 1) return this.#study();
    const choices = this.columns.map((name, at) => button(name, `Open a study with the noise of ${name}`, () => this.#study(at)));
    byId("log-choice").replaceChildren("Simulate:", ...choices);
    choices[0].focus();
  }

  /** Opens a study with the noise of the only column, or of one by its place. */
  async #study(column) {
    const { file } = this;
    byId("log-choice").replaceChildren();
    const signal = this.progress.begin("Writing a study with this noise");
    try {
      const { reply } = await engine.ask({ call: "study_of_log", name: file.name, options: this.options, column }, { blobs: [await this.#bytes(file)], isGiven: true, signal });
      this.openStudy(reply.text, file.name.replace(/\.\w+$/, ""));
    } catch (error) {
      this.#failed(error);
      if (error.kind === "usage") this.#askForOptions(error);
    } finally {
      this.progress.end(signal);
    }
  }
}

/** Kinds of the numbers of a log. */
const DATA = { rate: "rates", increment: "increments", angle: "angles" };

const significant = (number) => Number(number.toPrecision(4)).toString();

function length(duration) {
  const [size, unit] = [[86400, "d"], [3600, "h"], [60, "min"]].find(([size]) => duration >= 2 * size) ?? [1, "s"];
  return `${significant(duration / size)} ${unit}`;
}
