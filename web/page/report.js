// A report.html of the program, shown in a frame as high as its content.

import { element } from "./elements.js";

/** Longest time in ms that a report may take to draw its charts before it is shown without them. */
const PATIENCE = 1500;

const all = new Set();

/** Reports follow the choice of light or dark. */
export function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  all.forEach((report) => report.adapt());
}

export class Report {
  #removed = () => {};

  constructor(host) {
    this.host = host;
    this.frame = null;
    all.add(this);
  }

  /** Shows a report in place of the one before, once its charts are drawn. */
  async show(html, title) {
    this.#cancel();
    const url = URL.createObjectURL(new Blob([html], { type: "text/html" }));
    const frame = element("iframe", { title: `Report: ${title}`, src: url, class: "incoming", allow: "clipboard-write" });
    this.incoming = frame;
    const loaded = new Promise((resolve) => {
      frame.addEventListener("load", resolve, { once: true });
      // A frame that is removed before never loads.
      this.#removed = resolve;
    });
    this.host.append(frame);
    await loaded;
    URL.revokeObjectURL(url);
    if (this.incoming !== frame) return;
    await drawn(frame.contentDocument);
    if (this.incoming !== frame) return;
    this.incoming = null;
    this.frame?.remove();
    this.frame = frame;
    this.adapt();
    frame.classList.remove("incoming");
    fit(frame);
  }

  clear() {
    this.#cancel();
    this.frame?.remove();
    this.frame = null;
  }

  #cancel() {
    this.incoming?.remove();
    this.incoming = null;
    this.#removed();
  }

  adapt() {
    const page = this.frame?.contentDocument;
    if (!page) return;
    const theme = document.documentElement.dataset.theme;
    if (theme) page.documentElement.dataset.theme = theme;
    // The site has title, navigation and switch of its own, and links to a chart lead to the file of a report.
    const links = [...page.querySelectorAll("button")].filter((made) => made.title.startsWith("Copy a link to this chart"));
    for (const part of [...page.querySelectorAll("body > header, .skip"), ...links]) part.style.display = "none";
  }
}

function drawn(page) {
  const isReady = () => page.body?.dataset.ready === "true";
  if (isReady()) return Promise.resolve();
  return new Promise((resolve) => {
    const observer = new MutationObserver(() => isReady() && resolve());
    observer.observe(page.body, { attributes: true });
    setTimeout(resolve, PATIENCE);
  });
}

/** Keeps a frame as high as its page, which so scrolls with the site. */
function fit(frame) {
  const root = frame.contentDocument.documentElement;
  const set = () => {
    frame.style.height = `${Math.ceil(root.getBoundingClientRect().height) + 2}px`;
  };
  new ResizeObserver(set).observe(root);
  set();
}
