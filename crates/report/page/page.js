// The page: unpacks its data, and makes of each chart and table what can be used.

async function unpacked() {
  const packed = Uint8Array.from(atob(document.getElementById("data").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
}

/** A chart of curves, or a map, with its tools and legend. */
function chart(host, { stem, picture, axes, words }) {
  const figure = host.closest("figure");
  for (const name of ["x", "y", "z"]) if (axes[name]) picture[name].ladders = axes[name];
  picture.edges = axes.edges;
  picture.words = words;
  // Instead of the still picture.
  host.replaceChildren();
  const drawing = element("div", { class: "drawing" });
  if (picture.kind === "curves") {
    const subject = new Curves(picture);
    const plot = linked(new Plot(drawing, subject, picture.title), figure);
    host.append(element("div", { class: "beside" }, drawing, subject.legend(plot)), tools(plot, stem));
    return;
  }
  const under = element("div", { class: "slices" });
  const slices = [];
  const subject = new CellMap(picture, (...figures) => {
    figures.forEach(({ title, figure }, at) => {
      slices[at] ??= sliced(under, `${stem}-${at === 0 ? "x" : "y"}`);
      slices[at](title, figure);
    });
  });
  const plot = linked(new Plot(drawing, subject, picture.title), figure);
  const zLog = button("z log", "Logarithmic or linear colours", (event) => {
    subject.zLog = !subject.zLog;
    event.currentTarget.setAttribute("aria-pressed", subject.zLog);
    plot.render();
  }, subject.zLog);
  host.append(element("div", { class: "beside" }, drawing, subject.legend()), tools(plot, stem, subject.winners || subject.isYesOrNo ? [] : [zLog]),
    element("p", { class: "hint" }, "Click on a cell, or move by arrow keys, to see the slices through it."), under);
  plot.render();
  const middle = subject.told(plot, subject.across.shown.length >> 1, subject.up.shown.length >> 1);
  if (middle) subject.choose(middle);
}

/** A plot whose enlarged part is in the address of the page, as its part of the fragment says from the start. */
function linked(plot, figure) {
  const apply = () => {
    const [id, query] = location.hash.slice(1).split("?");
    if (id !== figure.id) return;
    if (query) plot.restore(query);
    figure.scrollIntoView();
  };
  plot.changed = () => history.replaceState(null, "", `#${figure.id}${plot.state()}`);
  apply();
  addEventListener("hashchange", apply);
  return plot;
}

/** Room for a slice; what it returns draws one there. */
function sliced(host, file) {
  const heading = element("h4");
  const drawing = element("div", { class: "drawing" });
  const made = element("div", { class: "slice" }, heading, drawing);
  host.append(made);
  let plot = null;
  return (title, figure) => {
    heading.textContent = title;
    const subject = new Curves(figure);
    subject.height = (width) => Math.min(Math.max(0.6 * width, 220), 320);
    if (plot) {
      plot.subject = subject;
      plot.show(null);
      return;
    }
    plot = new Plot(drawing, subject, `slice at ${title}`);
    made.append(tools(plot, file));
  };
}

/** Light or dark, as the system has it until the reader chooses. */
function theme() {
  const root = document.documentElement;
  const switcher = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.dataset.theme ?? (system.matches ? "dark" : "light")) === "dark";
  const label = () => switcher.setAttribute("aria-pressed", isDark());
  // Pages in files may have no storage.
  const kept = (act) => {
    try {
      return act(localStorage);
    } catch {
      return null;
    }
  };
  const chosen = kept((storage) => storage.getItem("sagnac-theme"));
  if (chosen) root.dataset.theme = chosen;
  switcher.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    kept((storage) => storage.setItem("sagnac-theme", root.dataset.theme));
    label();
  });
  system.addEventListener("change", label);
  label();
}

/** Offers what is shown of files as files. */
function files() {
  document.querySelectorAll("pre[data-file]").forEach((text) => {
    const name = text.dataset.file.replace(/^inputs\//, "").replaceAll("/", "-");
    text.before(button(`Save ${name}`, `Save ${name} as a file`, () => save(name, "text/plain", text.textContent)));
  });
}

/** A text of which no line ends between a number and its unit, or within an interval or a name such as LGV-1. */
const whole = (text) => text.replace(/([\d≤≥=]) (?=\S)/g, "$1\u00a0").replace(/[-–](?=\d)/g, "$&\u2060");

/** A button that copies the answer as text: its headline, its table with tabs, and its facts. */
function answer() {
  const card = document.getElementById("answer");
  const headline = card?.querySelector(".headline");
  if (!headline?.textContent) return;
  const texts = (parent, selector) => [...parent.querySelectorAll(selector)].map((each) => each.textContent.trim());
  const text = [headline.textContent, ...[...card.querySelectorAll(".options tr")].map((row) => texts(row, "th, td").join("\t")),
    ...texts(card, ".facts dt").map((name, at) => `${name}\t${texts(card, ".facts dd")[at]}`)].join("\n") + "\n";
  [...card.querySelectorAll("details.more")].at(-1).append(button("Copy answer", "Copy the answer with its table as text", (event) => copy(text, event.currentTarget)));
  card.querySelectorAll(".options :is(th, td)").forEach((each) => each.replaceChildren(element("div", {}, whole(each.textContent))));
  // On phones the first chart comes before what else is worth knowing. A frame may get its width later.
  const narrow = matchMedia("(max-width: 700px)");
  const fold = () => card.querySelectorAll("details.more").forEach((each) => { each.open = !narrow.matches; });
  narrow.addEventListener("change", () => Plot.onPaper || fold());
  fold();
}

document.querySelectorAll("#closed-forms td:last-child").forEach((each) => {
  each.textContent = whole(each.textContent);
});
theme();
files();
answer();

/** The facts open, and pictures as wide as paper, or as before. */
function paper(isPrinted) {
  document.querySelectorAll("details.more").forEach((each) => {
    if (isPrinted) each.dataset.open = each.open;
    each.open = isPrinted || each.dataset.open === "true";
  });
  Plot.onPaper = isPrinted;
  Plot.all.forEach((plot) => plot.render());
}

addEventListener("beforeprint", () => paper(true));
addEventListener("afterprint", () => paper(false));
unpacked().then((data) => {
  looks = data.looks;
  document.querySelectorAll("[data-chart]").forEach((host) => chart(host.querySelector(".plot"), data.charts[host.dataset.chart]));
  document.querySelectorAll("[data-table]").forEach((host) => new Listing(host.querySelector(".listing"), data.tables[host.dataset.table]));
  document.body.dataset.ready = "true";
}).catch((error) => {
  document.querySelector("main").prepend(element("p", { class: "note", role: "alert" },
    `This browser shows the charts as still pictures and only the first rows of tables (${error}); use one of 2024 or later.`));
  throw error;
});
