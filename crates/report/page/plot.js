// A frame with two axes: its layout, its scales, the part that is enlarged, and where the reader points.

let plots = 0;

/** The width of a picture on paper, px: its writing is then as large as that beside it. */
const PAPER = 420;

class Plot {
  /** All there are, and whether they are to be printed. */
  static all = [];
  static onPaper = false;

  /**
   * `subject` is what is shown: `x` and `y`, its axes; `ranges(xLog, yLog)`, the whole of it; `draw(plot, under, over)`, which fills
   * two groups, of which the first is cut at the frame; `near(plot, x, y)`, what stands near a place, or null, as `{ place, tell }`;
   * `step(plot, key)`, what an arrow key leads to; `height(width)`.
   */
  constructor(host, subject, name) {
    this.subject = subject;
    this.name = name;
    this.pins = [];
    this.log = { x: subject.x.scale === "log", y: subject.y.scale === "log" };
    this.part = null;
    this.id = `plot-${++plots}`;
    this.picture = shape("svg", {
      tabindex: 0, role: "application", "aria-roledescription": "chart", "aria-label": `${name}. Arrow keys read values, plus and minus enlarge, 0 shows all.`,
      pointermove: (event) => this.move(event), pointerdown: (event) => this.press(event),
      pointerup: (event) => this.release(event), pointercancel: () => this.leave(),
      // A finger leaves when it is lifted; what it has read off stays.
      pointerleave: (event) => event.pointerType === "mouse" && this.leave(),
      dblclick: () => this.whole(), keydown: (event) => this.key(event), blur: () => this.tell(null),
    });
    host.append(this.picture);
    this.host = host;
    Plot.all.push(this);
    // What is read off stands beside its place in the window.
    addEventListener("scroll", () => this.told && this.tell(null), { passive: true });
    addEventListener("pointerdown", (event) => this.told && !this.picture.contains(event.target) && this.tell(null));
    new ResizeObserver(() => {
      if (this.width === this.room()) return;
      this.tell(null);
      this.render();
    }).observe(host);
    this.render();
  }

  room() {
    return Plot.onPaper ? PAPER : Math.max(Math.round(this.host.clientWidth), 240);
  }

  render() {
    const { subject, picture } = this;
    this.width = this.room();
    this.height = subject.height ? subject.height(this.width) : Math.min(Math.max(0.62 * this.width, 300), 520);
    const all = subject.ranges(this.log.x, this.log.y);
    this.ranges = this.part ?? all;
    const small = this.width < 480;
    this.small = small;
    const size = small ? 11 : 13;
    const rows = subject.y.names ?? [];
    const yTicks = rows.length > 0 ? this.ranges.y.names(rows) : this.ranges.y.ticks(small ? 6 : 8, subject.y.ladders);
    const widest = Math.max(...yTicks.major.map((tick) => textWidth(tick.label, size)), 12);
    const labels = rows.length > 0 ? Math.min(widest, this.width / 3) : widest;
    const top = 12;
    const names = subject.x.names ?? [];
    this.frame = { left: labels + size + 24, top, right: this.width - 14, bottom: this.height - (names.length > 0 ? 5.6 : 3.4) * size };
    let xTicks = this.xTicks();
    // The last label may reach beyond its tick by more than the margin.
    const ends = names.length > 0 ? [] : xTicks.major.map(({ value, label }) => this.across(value) + textWidth(label, size) / 2 + 2);
    const beyond = Math.max(...ends, 0) - this.width;
    if (beyond > 0) {
      this.frame.right -= beyond;
      xTicks = this.xTicks();
    }
    const { left, right, bottom } = this.frame;
    picture.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    picture.style.setProperty("--size", `${size}px`);
    const under = shape("g", { "clip-path": `url(#${this.id})` });
    const over = shape("g");
    const clip = shape("clipPath", { id: this.id }, shape("rect", { x: left, y: top, width: right - left, height: bottom - top }));
    this.mark = shape("g", { class: "mark" });
    this.box = shape("rect", { class: "box", width: 0, height: 0 });
    this.pinned = shape("g", { class: "pinned" });
    picture.replaceChildren(clip, this.grid(xTicks, yTicks), under, this.axes(xTicks, yTicks, size), over, this.pinned, this.mark, this.box);
    subject.draw(this, under, over);
    this.drawPins();
  }

  /** The names under the axis x, or about as many ticks as its width has room for. */
  xTicks() {
    const { left, right } = this.frame;
    const { names, ladders } = this.subject.x;
    if (names?.length > 0) return this.ranges.x.names(names);
    return this.ranges.x.ticks(Math.max(Math.floor((right - left) / (this.small ? 52 : 70)), 2), ladders);
  }

  grid(xTicks, yTicks) {
    const { left, top, right, bottom } = this.frame;
    const across = (value) => `M${left},${this.down(value)}H${right}`;
    const down = (value) => `M${this.across(value)},${top}V${bottom}`;
    const path = (xs, ys) => xs.map(down).join("") + ys.map(across).join("");
    const values = (ticks) => ticks.major.map((tick) => tick.value);
    return shape("g", { class: "grid" },
      shape("path", { class: "minor", d: path(xTicks.minor, yTicks.minor) }),
      shape("path", { d: path(values(xTicks), values(yTicks)) }));
  }

  axes(xTicks, yTicks, size) {
    const { left, top, right, bottom } = this.frame;
    const group = shape("g", { class: "axes" });
    group.append(shape("path", { d: `M${left},${top}V${bottom}H${right}` }));
    let end = -Infinity;
    const room = xTicks.named ? (right - left) / (this.ranges.x.high - this.ranges.x.low) - 6 : null;
    for (const { value, label } of xTicks.major) {
      const [at, width] = [this.across(value), textWidth(label, size)];
      group.append(shape("path", { d: `M${at},${bottom}v5` }));
      if (room) {
        inLines(label, size, room).forEach((line, row) => group.append(
          shape("text", { x: at, y: bottom + (row + 1) * 1.2 * size + 6, "text-anchor": "middle" }, line)));
        continue;
      }
      if (at - width / 2 < end + 6) continue;
      group.append(shape("text", { x: at, y: bottom + size + 8, "text-anchor": "middle" }, label));
      end = at + width / 2;
    }
    // Names take at most a third of the width.
    const most = yTicks.named ? this.width / 3 : Infinity;
    for (const { value, label } of yTicks.major) {
      const at = this.down(value);
      if (yTicks.named) {
        const lines = inLines(label, size, most);
        lines.forEach((line, row) => group.append(
          shape("text", { x: left - 9, y: at + (0.36 + 1.2 * (row - (lines.length - 1) / 2)) * size, "text-anchor": "end" }, line)));
        continue;
      }
      group.append(shape("path", { d: `M${left},${at}h-5` }));
      group.append(shape("text", { x: left - 9, y: at + 0.36 * size, "text-anchor": "end" }, label));
    }
    // Long titles are smaller, so that they keep all their words.
    const title = (axis, middle, end, place) => {
      const text = axisTitle(axis);
      const room = 2 * Math.min(middle, end - middle) - 4;
      const fitted = Math.min(size, (size * room) / textWidth(text, size));
      group.append(shape("text", { class: "title", style: `font-size: ${fitted}px`, "text-anchor": "middle", ...place }, text));
    };
    const [across, down] = [(left + right) / 2, (top + bottom) / 2];
    title(this.subject.x, across, this.width, { x: across, y: this.height - 0.5 * size });
    title(this.subject.y, down, this.height, { transform: `translate(${size} ${down}) rotate(-90)` });
    return group;
  }

  /** The place of a value of x in the picture, and of one of y, to a hundredth of a px. */
  across(x) {
    const { left, right } = this.frame;
    return Math.round(100 * (left + this.ranges.x.fraction(x) * (right - left))) / 100;
  }

  down(y) {
    const { top, bottom } = this.frame;
    return Math.round(100 * (bottom - this.ranges.y.fraction(y) * (bottom - top))) / 100;
  }

  shows(x, y) {
    return Range.shows(this.log.x, x) && Range.shows(this.log.y, y);
  }

  inFrame([x, y]) {
    const { left, top, right, bottom } = this.frame;
    return x >= left - 0.5 && x <= right + 0.5 && y >= top - 0.5 && y <= bottom + 0.5;
  }

  /** Switches the scale of an axis. */
  setLog(axis, log) {
    this.log[axis] = log;
    this.show(null);
  }

  whole() {
    this.show(null);
  }

  /** Enlarges about what is read off, or the middle; below 1 it shows more. */
  enlarge(factor) {
    const { left, top, right, bottom } = this.frame;
    const [x, y] = this.told ? this.told.place : [(left + right) / 2, (top + bottom) / 2];
    const [u, v] = [(x - left) / (right - left), (bottom - y) / (bottom - top)];
    const ends = (at) => [at - at / factor, at + (1 - at) / factor];
    this.show({ x: this.ranges.x.part(...ends(u)), y: this.ranges.y.part(...ends(v)) });
  }

  show(part) {
    const told = this.told;
    this.part = part;
    this.tell(null);
    this.render();
    this.changed?.();
    if (told?.again) this.tell(told.again(this));
  }

  // Where the reader points.

  pointer(event) {
    const bounds = this.picture.getBoundingClientRect();
    const scale = this.width / bounds.width;
    return [(event.clientX - bounds.left) * scale, (event.clientY - bounds.top) * scale];
  }

  press(event) {
    if (event.button !== 0) return;
    const place = this.pointer(event);
    if (event.pointerType === "mouse" && this.inFrame(place)) {
      this.from = place;
      this.picture.setPointerCapture(event.pointerId);
    }
    this.tell(this.subject.near(this, ...place));
    if (this.subject.choose && this.told) this.subject.choose(this.told);
  }

  move(event) {
    const [x, y] = this.pointer(event);
    if (!this.from) {
      this.tell(this.inFrame([x, y]) ? this.subject.near(this, x, y) : null);
      return;
    }
    const box = this.boxTo(x, y);
    if (box) this.tell(null);
    for (const [name, value] of Object.entries(box ?? { width: 0 })) this.box.setAttribute(name, value);
  }

  release(event) {
    if (!this.from) return;
    const box = this.boxTo(...this.pointer(event));
    this.from = null;
    this.box.setAttribute("width", 0);
    if (!box) {
      this.pin();
      return;
    }
    const { left, top, right, bottom } = this.frame;
    const [u, v] = [(x) => (x - left) / (right - left), (y) => (bottom - y) / (bottom - top)];
    this.show({
      x: this.ranges.x.part(u(box.x), u(box.x + box.width)),
      y: this.ranges.y.part(v(box.y + box.height), v(box.y)),
    });
  }

  /** The part of the frame from where the pointer went down; none if it hardly moved. */
  boxTo(x, y) {
    const { left, top, right, bottom } = this.frame;
    const [x1, y1] = [Math.min(Math.max(x, left), right), Math.min(Math.max(y, top), bottom)];
    const [x0, y0] = this.from;
    const [width, height] = [Math.abs(x1 - x0), Math.abs(y1 - y0)];
    return width > 6 && height > 6 ? { x: Math.min(x0, x1), y: Math.min(y0, y1), width, height } : null;
  }

  leave() {
    this.from = null;
    this.box.setAttribute("width", 0);
    this.tell(null);
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const acts = {
      "+": () => this.enlarge(1.5), "=": () => this.enlarge(1.5), "-": () => this.enlarge(1 / 1.5), 0: () => this.whole(),
      Escape: () => this.tell(null), Enter: () => this.pin(),
    };
    if (event.key.startsWith("Arrow")) {
      this.tell(this.subject.step(this, event.key.slice(5)));
      if (this.subject.choose && this.told) this.subject.choose(this.told);
    } else if (acts[event.key]) acts[event.key]();
    else return;
    event.preventDefault();
  }

  /** The part that is shown and the scales, as in the fragment of a link; empty for the whole. */
  state() {
    if (!this.part) return "";
    const ends = ({ low, high }) => [low, high].map((end) => Number(end.toPrecision(4))).join();
    const log = ["x", "y"].filter((axis) => this.log[axis]).join("");
    return `?x=${ends(this.part.x)}&y=${ends(this.part.y)}&log=${log}`;
  }

  /** Shows the part of a fragment. */
  restore(query) {
    const given = new URLSearchParams(query);
    const ends = (axis) => given.get(axis)?.split(",").map(Number) ?? [];
    const log = given.get("log") ?? "";
    const isGood = (axis) => ends(axis).length === 2 && ends(axis)[0] < ends(axis)[1] && ends(axis).every((end) => Range.shows(log.includes(axis), end));
    if (!isGood("x") || !isGood("y")) return;
    for (const axis of ["x", "y"]) this.log[axis] = log.includes(axis);
    this.show({ x: new Range(this.log.x, ...ends("x")), y: new Range(this.log.y, ...ends("y")) });
  }

  /** Keeps what is read off below the chart; beside the first reading each further one has its differences from it. */
  pin() {
    if (!this.told || !this.subject.reading) return;
    this.pins.push(this.subject.reading(this.told.found));
    this.listPins();
  }

  listPins() {
    this.drawPins();
    const [first, ...others] = this.pins;
    if (!first) {
      this.pinList?.remove();
      this.pinList = null;
      return;
    }
    const { x, y } = this.subject;
    const row = (pin, at) => element("tr", {}, ...[at + 1, pin.name, axisValue(x, pin.x), measured(pin.y, y.unit)].map((text) => element("td", {}, String(text))),
      element("td", {}, at === 0 ? "" : `Δx ${measured(pin.x - first.x, x.unit)}, Δy ${measured(pin.y - first.y, y.unit)}, ratio ${significant(pin.y / first.y, READ)}`));
    const list = element("div", { class: "pins", role: "status" }, element("table", {}, row(first, 0), ...others.map((pin, at) => row(pin, at + 1))),
      button("Clear readings", "Remove the pinned readings", () => {
        this.pins = [];
        this.listPins();
      }));
    if (this.pinList) this.pinList.replaceWith(list);
    else this.host.append(list);
    this.pinList = list;
  }

  drawPins() {
    const shown = this.pins.map((pin, at) => ({ ...pin, at })).filter(({ x, y }) => this.shows(x, y) && this.inFrame([this.across(x), this.down(y)]));
    this.pinned.replaceChildren(...shown.flatMap(({ x, y, at }) => [
      shape("circle", { class: "pin", cx: this.across(x), cy: this.down(y), r: 8 }),
      shape("text", { class: "mark-label", x: this.across(x), y: this.down(y) - 12, "text-anchor": "middle" }, String(at + 1))]));
  }

  /** Shows what is read off, or nothing. */
  tell(told) {
    this.told = told;
    this.mark.replaceChildren(...(told ? told.marks : []));
    tip(this.picture, told && told.text(), told && told.place, this.width);
  }
}

/** A name in up to three lines that are about as long, cut where a word does not fit. */
function inLines(name, size, room) {
  const lines = (most) => {
    const made = [];
    for (const word of name.split(" ")) {
      const longer = `${made.at(-1)} ${word}`;
      if (made.length > 0 && (textWidth(longer, size) <= most || made.length === 3)) made[made.length - 1] = longer;
      else made.push(word);
    }
    return made;
  };
  let best = lines(room);
  for (let most = room - 4; most > 8; most -= 4) {
    const narrower = lines(most);
    if (narrower.length > best.length || narrower.some((line) => textWidth(line, size) > most)) break;
    best = narrower;
  }
  const cut = (line) => {
    let length = line.length;
    while (length > 1 && textWidth(`${line.slice(0, length)}…`, size) > room) length--;
    return `${line.slice(0, length)}…`;
  };
  return best.map((line) => (textWidth(line, size) <= room ? line : cut(line)));
}

/** The switches and buttons of a plot. */
function tools(plot, file, more = []) {
  const { subject, picture } = plot;
  const scale = (axis) => {
    if ((subject[axis].names ?? []).length > 0 || !(subject.canBeLog?.(axis) ?? true)) return null;
    return button(`${axis} log`, `Logarithmic or linear ${axis}`, (event) => {
      plot.setLog(axis, !plot.log[axis]);
      event.currentTarget.setAttribute("aria-pressed", plot.log[axis]);
    }, plot.log[axis]);
  };
  const link = plot.changed ? button("Link", "Copy a link to this chart and the part that is shown", (event) => {
    const { href } = Object.assign(new URL(location.href), { hash: file + plot.state() });
    copy(href, event.currentTarget);
  }) : null;
  return element("div", { class: "tools", role: "toolbar", "aria-label": `Tools of ${plot.name}` }, scale("x"), scale("y"), ...more,
    button("Zoom in", "Enlarge (+)", () => plot.enlarge(1.5)), button("Zoom out", "Show more (−)", () => plot.enlarge(1 / 1.5)),
    button("Reset", "Show all again (0)", () => plot.whole()),
    button("PNG", "Save what is shown as PNG", () => savePng(`${file}.png`, picture)),
    button("SVG", "Save what is shown as SVG", () => save(`${file}.svg`, "image/svg+xml", standalone(picture))),
    button("CSV", "Save the numbers of this chart as CSV", () => save(`${file}.csv`, "text/csv", subject.csv())), link);
}

/** Shows what is read off beside its place in a picture. */
function tip(picture, content, place, width) {
  const box = document.getElementById("tip");
  if (!content) {
    if (box.dataset.of === picture.dataset.tip) box.className = "";
    return;
  }
  picture.dataset.tip ??= String(++plots);
  box.dataset.of = picture.dataset.tip;
  box.replaceChildren(...content);
  box.className = "shown";
  const bounds = picture.getBoundingClientRect();
  const scale = bounds.width / width;
  const [x, y] = [bounds.left + place[0] * scale, bounds.top + place[1] * scale];
  const [w, h] = [box.offsetWidth, box.offsetHeight];
  const left = x + 16 + w < innerWidth ? x + 16 : x - 16 - w;
  box.style.left = `${Math.min(Math.max(left, 4), Math.max(innerWidth - w - 4, 4))}px`;
  box.style.top = `${Math.min(Math.max(y - h / 2, 4), Math.max(innerHeight - h - 4, 4))}px`;
}
