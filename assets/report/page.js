// The page: unpacks its data, and makes of each chart and table what can be used.

async function unpacked() {
  const packed = Uint8Array.from(atob(document.getElementById("data").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
}

/** A chart of curves, or a map, with its tools and legend. */
function chart(host, { stem, picture, axes, words }) {
  for (const name of ["x", "y", "z"]) if (axes[name]) picture[name].ladders = axes[name];
  picture.edges = axes.edges;
  picture.words = words;
  // Instead of the still picture.
  host.replaceChildren();
  const drawing = element("div", { class: "drawing" });
  if (picture.kind === "curves") {
    const subject = new Curves(picture);
    const plot = new Plot(drawing, subject, picture.title);
    host.append(tools(plot, stem), element("div", { class: "beside" }, drawing, subject.legend(plot)));
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
  const plot = new Plot(drawing, subject, picture.title);
  const zLog = button("z log", "Logarithmic or linear colours", (event) => {
    subject.zLog = !subject.zLog;
    event.currentTarget.setAttribute("aria-pressed", subject.zLog);
    plot.render();
  }, subject.zLog);
  host.append(tools(plot, stem, subject.winners ? [] : [zLog]), element("div", { class: "beside" }, drawing, subject.legend()),
    element("p", { class: "hint" }, "Click on a cell, or move by arrow keys, to see the slices through it."), under);
  plot.render();
  const middle = subject.told(plot, subject.across.shown.length >> 1, subject.up.shown.length >> 1);
  if (middle) subject.choose(middle);
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
    made.insertBefore(tools(plot, file), drawing);
  };
}

/** Light or dark, as the system has it until the reader chooses. */
function theme() {
  const root = document.documentElement;
  const switcher = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (root.dataset.theme ?? (system.matches ? "dark" : "light")) === "dark";
  const label = () => {
    switcher.textContent = isDark() ? "Light" : "Dark";
  };
  switcher.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
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

theme();
files();

/** Everything open, and pictures as wide as paper, or as before. */
function paper(isPrinted) {
  document.querySelectorAll("details").forEach((each) => {
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
