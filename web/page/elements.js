// Elements of the page, and what is saved and copied from it.

export const byId = (id) => document.getElementById(id);

/** An HTML element with attributes, or handlers where these are functions. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

export function button(label, title, act, attributes = {}) {
  return element("button", { type: "button", title, click: act, ...attributes }, label);
}

/** A note with what it quotes as code. */
export const note = (text) => element("p", { class: "note" }, ...text.split("`").map((part, at) => (at % 2 === 1 ? element("code", {}, part) : part)));

/** A whole number in groups of three digits, as reports write it. */
export const grouped = (number) => Math.round(number).toString().replace(/\B(?=(\d{3})+$)/g, "\u202f");

/** A time of computing, with two or three digits. */
export const seconds = (milliseconds) => `${(milliseconds / 1000).toFixed(milliseconds < 9950 ? 2 : 1)} s`;

/** Tells screen readers what happened. */
export function announce(text) {
  byId("said").textContent = text;
}

/** Shows the message of a failure as the terminal prints it, or hides it. */
export function showError(host, failure) {
  host.hidden = !failure;
  host.replaceChildren(...(failure ? [element("pre", { tabindex: "0", "aria-label": "Message" }, failure.message)] : []));
}

/** A word of a command as shells take it; a name that begins with a dash is no option. */
export function quoted(word) {
  const named = word.startsWith("-") ? `./${word}` : word;
  return /^[\w.,:@%+=/-]+$/.test(named) ? named : `'${named.replaceAll("'", `'\\''`)}'`;
}

/** A table of texts; cells that are numbers or elements are taken as they are. */
export function table(caption, columns, rows) {
  const heads = columns.map(({ label, isText }) => element("th", { scope: "col", class: isText ? "text" : null }, label));
  const lines = rows.map((row) => element("tr", {}, ...row.map((cell, at) => element("td", { class: columns[at].isText ? "text" : null }, cell))));
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    element("table", {}, element("caption", { class: "unseen" }, caption), element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...lines)));
}

/** Offers bytes or a text as a file. */
export function save(name, content) {
  const link = element("a", { href: URL.createObjectURL(new Blob([content])), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Buttons that save files. */
export function showFiles(host, files) {
  host.replaceChildren("Save:", ...files.map(({ name, bytes }) => button(name, `Save ${name}`, () => save(name, bytes))));
}

/** Copies a text, and says so on its button for a while. */
export async function copy(text, from) {
  from.dataset.label ??= from.textContent;
  try {
    await navigator.clipboard.writeText(text);
    from.textContent = "Copied";
  } catch {
    from.textContent = "The browser did not allow it";
  }
  announce(from.textContent);
  setTimeout(() => {
    from.textContent = from.dataset.label;
  }, 1500);
}

/** A line of progress with a button that stops the work. Its room stays, so that nothing jumps when work is short. */
export class Progress {
  /** `stopped` is called when the reader stops the work. */
  constructor(host, stopped = () => {}) {
    this.host = host;
    this.stopped = stopped;
    this.bar = element("progress", { max: "1", "aria-label": "Progress" });
    this.label = element("span", {});
    this.stop = button("Stop", "Stop this computation", () => this.#stop());
    host.replaceChildren(this.label, this.bar, this.stop);
    this.#state("idle");
  }

  /** One of "idle", "busy", "stopped". */
  #state(state) {
    this.host.dataset.state = state;
  }

  #stop() {
    this.abort();
    this.#state("stopped");
    this.label.textContent = "Stopped.";
    announce("Stopped");
    this.stopped();
  }

  /** Begins work that the button, or later work, stops by the signal returned. */
  begin(text) {
    this.abort();
    this.controller = new AbortController();
    this.label.textContent = text;
    this.bar.removeAttribute("value");
    this.#state("busy");
    return this.controller.signal;
  }

  abort() {
    this.controller?.abort();
  }

  set(done, all) {
    if (all > 0) this.bar.value = done / all;
  }

  /** Ends the work of this signal, unless it was stopped or other work has begun since. */
  end(signal) {
    if (this.controller.signal === signal && this.host.dataset.state === "busy") this.#state("idle");
  }
}
