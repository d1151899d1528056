// The view of a study: its text with sliders beside it, and its answer as they change.

import { Progress, announce, button, byId, copy, element, grouped, quoted, seconds, showError, showFiles } from "./elements.js";
import { engine, isStopped } from "./engine.js";
import { studyOf } from "./gallery.js";
import { Sliders, Sweeps } from "./inputs.js";
import { pack } from "./link.js";
import { Report } from "./report.js";

/** Most and fewest trials of each point while a slider moves; as many as end soon. */
const LIVE_TRIALS = 4096;
const FEWEST_TRIALS = 8;

/** Most trials of each point that are run without being asked for. */
const RESTED_TRIALS = 262144;

/** Times in ms without a change of the text after which it is read, and after which trials are refined. */
const TYPING = 150;
const REST = 400;

/** Times in ms in which a live run should end, and after which it starts again with fewer trials. */
const SOON = 300;
const LATE = 2000;

export class StudyView {
  constructor() {
    this.name = "study";
    this.text = byId("study-text");
    this.sliders = new Sliders(byId("sliders"), (span, value) => this.#slide(span, value));
    this.sweeps = new Sweeps(byId("sweeps"), (span, text) => this.#sweep(span, text));
    this.report = new Report(byId("study-report"));
    this.progress = new Progress(byId("study-progress"), () => this.#stopped());
    this.text.addEventListener("input", () => {
      this.sliders.disable();
      this.sweeps.disable();
      this.#edited(TYPING);
    });
    this.#buttons();
    // On phones the answer comes before the text.
    byId("study-source").open = !matchMedia("(max-width: 860px)").matches;
  }

  /** Shows a study; one that is not shipped `isOwn`, and the address will hold it. */
  open(text, name, isOwn = false) {
    this.progress.abort();
    this.name = name;
    this.isEdited = isOwn;
    this.ran = null;
    this.few = LIVE_TRIALS;
    this.text.value = text;
    this.study = null;
    this.sliders.clear();
    this.sweeps.clear();
    byId("study-files").replaceChildren();
    byId("study-ran").textContent = "";
    this.report.clear();
    this.#changed(0);
  }

  /** Goes on where leaving stopped it. */
  enter() {
    if (!this.isStopped && this.ran?.text !== this.text.value) this.#changed(0);
  }

  /** Stops what runs, when another view is shown. */
  leave() {
    clearTimeout(this.timer);
    clearTimeout(this.resting);
    this.progress.abort();
  }

  /** Puts a value between the quotes of a quoted one, and gives the length of what stands there then. */
  #slide([from, to], value) {
    this.sweeps.disable();
    const quote = /^["']/.exec(this.text.value.slice(from, to))?.[0] ?? "";
    const written = `${quote}${value}${quote}`;
    this.text.setRangeText(written, from, to);
    this.#edited(0);
    return written.length;
  }

  #sweep([from, to], text) {
    this.sliders.disable();
    this.text.setRangeText(text, from, to);
    this.#edited(TYPING);
    return text.length;
  }

  /** Nothing runs from now on until the text changes or the reader asks for it; an answer to another text is marked. */
  #stopped() {
    this.isStopped = true;
    this.isWaiting = false;
    clearTimeout(this.timer);
    clearTimeout(this.resting);
    this.again.hidden = false;
    byId("study-report").classList.toggle("stale", this.ran?.text !== this.text.value);
  }

  #edited(delay) {
    this.isEdited = true;
    this.#changed(delay);
  }

  #changed(delay) {
    this.isStopped = false;
    this.again.hidden = true;
    clearTimeout(this.timer);
    clearTimeout(this.resting);
    // A live run ends soon by itself, and shows something while a slider moves; a longer one would keep the workers from this change.
    if (!this.isLive || performance.now() - this.begun > SOON) this.progress.abort();
    this.timer = setTimeout(() => this.#live(), delay);
  }

  /** Reads the text and runs a few trials; while it does so, changes wait for their turn. */
  async #live() {
    if (this.isLive) {
      this.isWaiting = true;
      return;
    }
    this.isLive = true;
    let isDone;
    do {
      this.isWaiting = false;
      isDone = await this.#once();
    } while (this.isWaiting);
    this.isLive = false;
    if (!isDone || this.isStopped) return;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#rested(), REST);
  }

  /** The address holds the text from now on, so that reloading and going back keep it. */
  async #rested() {
    const { study } = this;
    const isHere = () => !byId("view-study").hidden && this.study === study && study !== null;
    if (!isHere()) return;
    const link = await this.link();
    if (!isHere() || this.isStopped) return;
    if (this.isEdited) history.replaceState(null, "", link);
    await this.#refine(Math.min(study.trials, RESTED_TRIALS));
  }

  /** Whether there is an answer to the text. */
  async #once() {
    const text = this.text.value;
    this.begun = performance.now();
    try {
      const { reply } = await engine.ask({ call: "inspect", ...await studyOf(text, this.name) });
      if (text !== this.text.value) {
        this.isWaiting = true;
        return false;
      }
      this.#inspected(reply);
      return await this.#few(Math.min(reply.trials, this.few));
    } catch (error) {
      this.study = null;
      this.#failed(error);
      return false;
    }
  }

  /** A live run, after which the next one has fewer or more trials by the time that this one took. */
  async #few(trials) {
    const before = this.ran;
    const late = trials > FEWEST_TRIALS && setTimeout(() => {
      // Computed, and only not drawn yet.
      if (this.ran !== before) return;
      this.few = Math.max(FEWEST_TRIALS, trials >> 3);
      this.isWaiting = true;
      this.progress.abort();
    }, LATE);
    const isDone = await this.#run(trials);
    clearTimeout(late);
    if (!isDone) return false;
    if (this.ran.took > SOON) this.few = Math.max(FEWEST_TRIALS, trials >> 1);
    else if (this.ran.took < SOON / 4) this.few = Math.min(LIVE_TRIALS, this.few * 2);
    return true;
  }

  #inspected(study) {
    this.study = study;
    showError(byId("study-error"), null);
    byId("study-report").classList.remove("stale");
    byId("title-study").textContent = study.title;
    document.title = `${study.title} · sagnac`;
    byId("study-question").textContent = study.question;
    this.sliders.set(study.keys);
    this.sweeps.set(study.sweeps, this.text.value);
    this.all.hidden = study.trials <= RESTED_TRIALS;
    this.all.textContent = `Run all ${grouped(study.trials)} trials`;
  }

  /** More trials of the same study, and then the facts of its answer that need sampling of their own. */
  async #refine(trials) {
    const isDone = this.ran?.text === this.text.value && this.ran.trials === trials;
    if (!isDone && !(await this.#run(trials))) return;
    if (!this.isStopped && this.ran.text === this.text.value && !this.ran.isComplete) await this.#complete(this.ran);
  }

  /** Whether the trials were run, and neither failed nor were stopped. */
  async #run(trials) {
    const study = await studyOf(this.text.value, this.name);
    const signal = this.progress.begin(`Running ${grouped(trials)} trials`);
    try {
      const begun = performance.now();
      const { rows, by } = await engine.sample(study, { trials, signal, progress: (...part) => this.progress.set(...part) });
      const answer = await engine.ask({ call: "outcome", ...study, trials, complete: false }, { blobs: rows, signal });
      this.ran = { ...study, trials, rows, by, took: performance.now() - begun, isComplete: !answer.reply.is_partial };
      await this.#show(answer, this.ran);
      return true;
    } catch (error) {
      this.#failed(error);
      return false;
    } finally {
      this.progress.end(signal);
    }
  }

  async #complete(ran) {
    const { text, name, files, trials, rows } = ran;
    const signal = this.progress.begin("Completing the answer");
    try {
      const answer = await engine.ask({ call: "outcome", text, name, files, trials, complete: true }, { blobs: rows, signal, progress: (...part) => this.progress.set(...part) });
      ran.isComplete = true;
      await this.#show(answer, ran);
    } catch (error) {
      this.#failed(error);
    } finally {
      this.progress.end(signal);
    }
  }

  #failed(error) {
    if (isStopped(error)) return;
    showError(byId("study-error"), error);
    byId("study-report").classList.add("stale");
  }

  async #show({ reply, blobs }, { text, name, trials, by, took }) {
    await this.report.show(blobs[0], this.study?.title ?? this.name);
    byId("study-report").classList.remove("stale");
    const tables = reply.files.map((name, at) => ({ name, bytes: blobs[at + 1] }));
    showFiles(byId("study-files"), [{ name, bytes: text }, { name: "report.html", bytes: blobs[0] }, ...tables]);
    byId("study-ran").replaceChildren(`${this.study?.is_sampled === false ? "closed forms" : `${by} · ${grouped(trials)} trials per point`} · ${seconds(took)} · points.csv `,
      element("code", { title: reply.digest }, reply.digest.slice(0, 12)), " · these are the bits of the program");
    announce(reply.headline);
  }

  #buttons() {
    this.all = button("Run all trials", "Run as many trials as the study says", () => {
      clearTimeout(this.resting);
      this.isStopped = false;
      this.again.hidden = true;
      if (this.study) this.#refine(this.study.trials);
    }, { hidden: true });
    this.again = button("Run again", "Run this study again, which was stopped", () => this.#changed(0), { hidden: true });
    byId("study-actions").append(
      this.all,
      this.again,
      button("Copy link", "Copy a link that holds the whole study", async ({ currentTarget }) => copy(await this.link(), currentTarget)),
      button("Copy command", "Copy the command that repeats this in a terminal", ({ currentTarget }) => copy(this.#command(), currentTarget)));
  }

  /** The address of this site with the study in its fragment. */
  async link() {
    const link = new URL(location);
    link.hash = `s=${await pack(this.text.value)}`;
    return link.href;
  }

  #command() {
    const fewer = this.ran && this.study && this.ran.trials !== this.study.trials ? ` --trials ${this.ran.trials}` : "";
    return `sagnac run ${quoted(`${this.name}.toml`)}${fewer}`;
  }
}
