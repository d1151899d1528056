// The site: its views by the fragment of the address, files that are dropped or pasted, light or dark, and use without a network.

import { announce, byId, element } from "./elements.js";
import { engine } from "./engine.js";
import { ConvertView } from "./convert.js";
import { gallery } from "./gallery.js";
import { unpack } from "./link.js";
import { LogView } from "./log.js";
import { setTheme } from "./report.js";
import { StudyView } from "./study.js";
import { VerifyView } from "./verify.js";

const VIEWS = ["log", "studies", "study", "convert", "verify"];

const study = new StudyView();
const log = new LogView((text, name) => {
  study.open(text, name, true);
  history.pushState(null, "", "#study");
  show("study");
});
const convert = new ConvertView();
new VerifyView(engine.about);

function show(view) {
  for (const each of VIEWS) byId(`view-${each}`).hidden = each !== view;
  const tab = view === "study" ? "studies" : view;
  document.querySelectorAll(".bar nav a").forEach((link) => {
    if (link.hash === `#${tab}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  });
  document.title = `${document.querySelector(`#view-${view} h1`).textContent} · sagnac`;
  if (view !== "study") study.leave();
  if (view === "studies" || view === "study") engine.warm().catch(() => {});
  if (view === "convert") convert.enter();
}

function trouble(text) {
  byId("trouble").hidden = !text;
  byId("trouble").textContent = text;
}

/** Shows the view of the fragment. */
async function route() {
  const [, view, value] = /^#?([a-z]*)=?(.*)$/s.exec(location.hash) ?? [];
  trouble("");
  if (view === "s") await openLink(value);
  else if (view === "study" && value) await openShipped(decodeURIComponent(value));
  else if (view === "study" && !study.text.value) show("studies");
  else show(VIEWS.includes(view) ? view : "log");
  if (view === "study" && !value && study.text.value) study.enter();
}

async function openLink(packed) {
  show("study");
  try {
    const text = await unpack(packed);
    // Going back to a study that was edited keeps its name and its answer.
    if (text === study.text.value) study.enter();
    else study.open(text, "study");
  } catch {
    show("studies");
    trouble("This link does not hold a whole study: it was cut off or changed on its way. Ask for it again, or open one of these.");
  }
}

async function openShipped(name) {
  const found = (await gallery).find((each) => each.name === name);
  if (!found) {
    show("studies");
    trouble(`There is no study called ${name}. These are the shipped ones.`);
    return;
  }
  show("study");
  study.open(found.text, name);
}

async function showGallery() {
  const cards = (await gallery).map(({ name, title, question, kind, picture }) => element("article", {},
    element("a", { href: `#study=${encodeURIComponent(name)}` },
      element("div", { class: "thumbnail" }, element("img", { src: picture, alt: "", loading: "lazy", width: "1000", height: "650" })),
      element("h2", {}, title)),
    element("p", { class: "question" }, question),
    element("p", { class: "hint" }, `${name} · ${kind}`)));
  byId("gallery").replaceChildren(...cards);
}

/** Opens a dropped, chosen or pasted file: a study where it is one, else a log, or two of them. */
async function open(file, second) {
  trouble("");
  if (/\.toml$/i.test(file.name)) {
    study.open(await file.text(), file.name.replace(/\.toml$/i, ""), true);
    history.pushState(null, "", "#study");
    show("study");
    return;
  }
  if (byId("view-log").hidden) {
    history.pushState(null, "", "#log");
    show("log");
  }
  if (second) log.openBoth(file, second);
  else log.open(file);
}

function dropping() {
  const over = byId("over");
  const hasFiles = (event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragover", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    over.hidden = false;
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) over.hidden = true;
  });
  addEventListener("drop", (event) => {
    over.hidden = true;
    if (!event.dataTransfer?.files.length) return;
    event.preventDefault();
    const [first, second, ...others] = event.dataTransfer.files;
    open(first, second).then(() => others.length > 0 && trouble("Two logs are compared; the other files were left out."), (error) => trouble(error.message));
  });
  addEventListener("paste", (event) => {
    if (event.target.closest?.("input, textarea")) return;
    const { files } = event.clipboardData;
    const text = event.clipboardData.getData("text/plain");
    if (files.length > 0) open(files[0]);
    else if (/\n/.test(text)) open(new File([text], "pasted.csv"));
  });
}

/** Light or dark, as the system has it until the reader chooses. */
function theming() {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (document.documentElement.dataset.theme ?? (system.matches ? "dark" : "light")) === "dark";
  const label = () => byId("theme").setAttribute("aria-pressed", String(isDark()));
  byId("theme").addEventListener("click", () => {
    setTheme(isDark() ? "light" : "dark");
    label();
  });
  system.addEventListener("change", label);
  label();
}

function skipping() {
  byId("skip").addEventListener("click", (event) => {
    event.preventDefault();
    byId("main").focus();
  });
}

async function introduce() {
  try {
    const { version } = await engine.about;
    byId("about").textContent = `sagnac ${version}, ${await engine.description()}.`;
  } catch (error) {
    trouble(error.message);
  }
}

theming();
skipping();
dropping();
addEventListener("hashchange", () => route().catch((error) => trouble(error.message)));
introduce();
showGallery().catch(() => announce("The list of studies could not be loaded"));
route().catch((error) => trouble(error.message));
// Without a service worker, as in some private windows, the site works while there is a network.
navigator.serviceWorker?.register("sw.js").catch(() => {});
