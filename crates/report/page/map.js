// Maps: a cell for each pair of values of x and y, by colour or by who has the least, with slices through the cell pointed at.

class CellMap {
  constructor(map, slices) {
    this.map = map;
    this.x = map.x;
    this.y = map.y;
    this.slices = slices;
    this.winners = map.cells.winners ?? null;
    this.zLog = map.z.scale === "log";
    // The page gives entries for winners, and for yes and no.
    this.isYesOrNo = !this.winners && map.words.entries.length > 0;
  }

  height(width) {
    return Math.min(Math.max(0.66 * width, 300), 540);
  }

  /** Columns (0) or rows (1) that the scale can show, with the edges of their cells. */
  along(side, log) {
    const values = side === 0 ? this.map.columns : this.map.rows;
    const shown = values.map((value, at) => ({ value, at })).filter(({ value }) => Range.shows(log, value));
    return { shown, edges: this.map.edges[side][log ? "log" : "linear"] };
  }

  ranges(xLog, yLog) {
    const of = (side, log) => {
      const { edges } = this.along(side, log);
      return new Range(log, edges[0], edges[edges.length - 1]);
    };
    return { x: of(0, xLog), y: of(1, yLog) };
  }

  /** The value of a cell: that of the winner, or the one shown; null if it is not known. */
  value(cell) {
    if (this.winners) return this.winners.won[cell]?.value ?? null;
    const estimate = this.map.layers[0]?.values[cell];
    return estimate && Range.shows(this.zLog, estimate[0]) ? estimate[0] : null;
  }

  /** The scale of the colours, which reaches as far on either side of a limit. */
  colours() {
    let [low, high] = [Infinity, -Infinity];
    for (let cell = 0; cell < this.map.columns.length * this.map.rows.length; cell++) {
      const value = this.value(cell);
      if (value !== null) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    const limit = this.limitOfColours();
    if (limit !== null && (low < limit || limit < high)) {
      const shown = new Range(this.zLog, low, high);
      const [from, middle, to] = [low, limit, high].map((value) => shown.coordinate(value));
      const reach = Math.max(to - middle, middle - from);
      const [lower, upper] = [middle - reach, middle + reach].map((at) => (this.zLog ? 10 ** at : at));
      return new Range(this.zLog, lower, upper);
    }
    return low < high ? new Range(this.zLog, low, high) : Range.around(this.zLog, low === high ? [low] : []);
  }

  /** The limit about which the colours diverge, or null. */
  limitOfColours() {
    const limit = this.map.limit?.value;
    return limit !== undefined && Range.shows(this.zLog, limit) ? limit : null;
  }

  shade(fraction) {
    const shades = this.limitOfColours() === null ? looks.viridis : looks.diverging;
    return shades[Math.round(Math.min(Math.max(fraction, 0), 1) * (shades.length - 1))];
  }

  draw(plot, under, over) {
    const { map, winners } = this;
    const [across, up] = [this.along(0, plot.log.x), this.along(1, plot.log.y)];
    const [xs, ys] = [across.edges.map((edge) => plot.across(edge)), up.edges.map((edge) => plot.down(edge))];
    Object.assign(this, { across, up, xs, ys });
    const colours = this.colours();
    const paths = new Map();
    let hatched = "";
    this.each((cell, rectangle) => {
      const value = this.value(cell);
      if (value === null) return;
      const won = winners?.won[cell];
      const two = this.isYesOrNo ? `cell c${value === 1 ? 1 : 2}` : this.shade(colours.fraction(value));
      const look = won ? `cell c${won.style % 8}${won.certain ? "" : " pale"}` : two;
      paths.set(look, (paths.get(look) ?? "") + rectangle);
      if (won && map.limit && value > map.limit.value) hatched += rectangle;
    });
    const cells = shape("g", { class: "cells" });
    for (const [look, d] of paths) cells.append(shape("path", look.startsWith("#") ? { fill: look, stroke: look, d } : { class: look, d }));
    under.append(cells);
    if (hatched) under.append(hatching(`${plot.id}-hatch`), shape("path", { fill: `url(#${plot.id}-hatch)`, d: hatched }));
    if (winners) under.append(shape("path", { class: "boundary", d: this.boundaries() }));
    else if (map.limit && Range.shows(this.zLog, map.limit.value)) this.limit(plot, under, colours);
    if (paths.size === 0) {
      const { left, right, top, bottom } = plot.frame;
      over.append(shape("text", { class: "nothing", x: (left + right) / 2, y: (top + bottom) / 2, "text-anchor": "middle" },
        "no value has a place on these axes"));
    }
    this.bar?.replaceChildren(...this.colourBar());
  }

  /** Every cell with its rectangle in px, as a path. */
  each(act) {
    const { across, up, xs, ys } = this;
    up.shown.forEach((row, j) => across.shown.forEach((column, i) => {
      const path = `M${xs[i]},${ys[j]}H${xs[i + 1]}V${ys[j + 1]}H${xs[i]}Z`;
      act(row.at * this.map.columns.length + column.at, path);
    }));
  }

  /** The line along which the values reach the limit, between the middles of the cells. */
  limit(plot, under, colours) {
    const { across, up, map } = this;
    const xs = across.shown.map(({ value }) => plot.across(value));
    const ys = up.shown.map(({ value }) => plot.down(value));
    const level = (column, row) => {
      const value = this.value(up.shown[row].at * map.columns.length + across.shown[column].at);
      return value === null ? null : colours.coordinate(value);
    };
    const d = contourPath(xs, ys, level, colours.coordinate(map.limit.value));
    if (d) under.append(shape("path", { class: "limit halo", d }), shape("path", { class: "limit solid", d }));
  }

  /** Lines between cells of different winners. */
  boundaries() {
    const { across, up, xs, ys } = this;
    const style = (i, j) => this.winners.won[up.shown[j].at * this.map.columns.length + across.shown[i].at]?.style;
    const differ = (a, b) => a !== undefined && b !== undefined && a !== b;
    let path = "";
    for (let j = 0; j < up.shown.length; j++) {
      for (let i = 0; i < across.shown.length; i++) {
        if (i > 0 && differ(style(i, j), style(i - 1, j))) path += `M${xs[i]},${ys[j]}V${ys[j + 1]}`;
        if (j > 0 && differ(style(i, j), style(i, j - 1))) path += `M${xs[i]},${ys[j]}H${xs[i + 1]}`;
      }
    }
    return path;
  }

  // Reading values.

  near(plot, x, y) {
    const within = (edges, at) => edges.findIndex((edge, i) => i > 0 && (at - edge) * (at - edges[i - 1]) <= 0) - 1;
    return this.told(plot, within(this.xs, x), within(this.ys, y));
  }

  step(plot, way) {
    const { i, j } = plot.told?.found ?? { i: -1, j: 0 };
    const [right, up] = [(way === "Right") - (way === "Left"), (way === "Up") - (way === "Down")];
    // Within the frame, of which a part may be enlarged.
    const { left, right: end, top, bottom } = plot.frame;
    const middles = (edges) => edges.slice(1).map((edge, at) => (edge + edges[at]) / 2);
    const clamped = (at, edges, low, high) => {
      const shown = middles(edges).map((middle, cell) => (middle >= low && middle <= high ? cell : -1)).filter((cell) => cell >= 0);
      return shown.length ? Math.min(Math.max(at, shown[0]), shown[shown.length - 1]) : at;
    };
    return this.told(plot, clamped(i + right, this.xs, left, end), clamped(j + up, this.ys, top, bottom));
  }

  told(plot, i, j) {
    const { across, up, xs, ys, map } = this;
    if (!across.shown[i] || !up.shown[j]) return null;
    const found = { i, j, column: across.shown[i].at, row: up.shown[j].at };
    const place = [(xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2];
    const marks = [shape("path", { class: "chosen", d: `M${xs[i]},${ys[j]}H${xs[i + 1]}V${ys[j + 1]}H${xs[i]}Z` })];
    return { found, place, marks, text: () => this.text(found.row * map.columns.length + found.column, found) };
  }

  text(cell, { column, row }) {
    const { map, winners } = this;
    const lines = map.layers.map((layer) => ({ layer, estimate: layer.values[cell] }))
      .sort((a, b) => (a.estimate?.[0] ?? Infinity) - (b.estimate?.[0] ?? Infinity))
      .map(({ layer, estimate }, at) => element("tr", { class: at === 0 ? "first" : null },
        winners ? element("td", {}, element("i", { class: `swatch c${layer.style % 8}` })) : null,
        element("td", {}, layer.name || map.z.label),
        element("td", {}, ...(estimate ? [element("b", {}, measured(estimate[0], map.z.unit)),
          element("small", {}, estimate[1] ? ` 95 %: ${significant(estimate[1][0], READ)} … ${significant(estimate[1][1], READ)}` : "")] : ["not known"]))));
    const close = winners?.won[cell] && !winners.won[cell].certain ? element("p", {}, "the 95 % bands of the best two overlap") : null;
    return [element("p", { class: "at" }, axisValue(map.x, map.columns[column])), element("p", { class: "at" }, axisValue(map.y, map.rows[row])),
      element("table", {}, ...lines), close].filter(Boolean);
  }

  /** Draws the slices through a cell. */
  choose({ found: { column, row } }) {
    this.slices?.(this.slice("x", column, row), this.slice("y", column, row));
  }

  /** The values along one axis through a cell, as a chart of curves. */
  slice(name, column, row) {
    const { map } = this;
    const along = name === "x" ? map.columns : map.rows;
    const cell = (at) => (name === "x" ? row * map.columns.length + at : at * map.columns.length + column);
    const series = map.layers.map((layer) => ({
      colour: layer.style, dash: 0, law: [],
      points: along.map((x, at) => ({ x, estimate: layer.values[cell(at)] })).filter(({ estimate }) => estimate)
        .map(({ x, estimate: [y, band] }) => ({ x, y, band })),
    }));
    const at = name === "x" ? axisValue(map.y, map.rows[row]) : axisValue(map.x, map.columns[column]);
    return {
      title: at,
      figure: {
        x: map[name], y: { ...map.z, scale: this.zLog || isWide(series) ? "log" : "linear" },
        colours: { title: "", entries: map.layers.filter((layer) => layer.name).map(({ style, name: text }) => ({ style, name: text })) },
        dashes: { title: "", entries: [] }, series, laws: [], parts: { title: "", lines: [] }, limit: map.limit, chosen: [],
        points: "", bands: "95 %", lines: "",
      },
    };
  }

  /** The numbers of the map, a row for each cell. */
  csv() {
    const { map } = this;
    const rows = map.layers.flatMap((layer) => layer.values.map((estimate, cell) => [map.columns[cell % map.columns.length],
      map.rows[Math.floor(cell / map.columns.length)], layer.name, estimate?.[0], ...(estimate?.[1] ?? ["", ""])]));
    return csvOf([[axisTitle(map.x), axisTitle(map.y), "curve", axisTitle(map.z), "lower", "upper"], ...rows]);
  }

  // The legend.

  legend() {
    const { map, winners } = this;
    const group = (title, ...entries) => element("div", { class: "group" }, title ? element("h4", {}, title) : null, ...entries.filter(Boolean));
    const sample = (look, name) => element("p", { class: "entry" },
      shape("svg", { class: "sample", viewBox: "0 0 36 18", "aria-hidden": "true" }, ...look), element("span", {}, name));
    const block = (look) => shape("rect", { x: 2, y: 2, width: 32, height: 14, ...look });
    const { words } = map;
    const chosen = map.chosen.length ? group("shown", ...map.chosen.map((text) => element("p", {}, text))) : null;
    const blank = words.blank ? element("p", {}, words.blank) : null;
    const entries = words.entries.map(([style, text]) => sample([block({ class: `cell c${style % 8}` })], text));
    if (this.isYesOrNo) return element("div", { class: "legend" }, ...[group(map.z.label, ...entries), group(null, blank), chosen].filter(Boolean));
    if (!winners) {
      this.bar = shape("svg", { class: "colour-bar", viewBox: "0 0 120 260" });
      this.bar.append(...this.colourBar());
      const limit = words.limit ? sample([sampleLine({ class: "limit solid" })], words.limit) : null;
      return element("div", { class: "legend" }, ...[group(axisTitle(map.z), this.bar), group(null, limit, blank), chosen].filter(Boolean));
    }
    const id = `hatch-${++plots}`;
    return element("div", { class: "legend" },
      ...[group(winners.of.title, element("p", {}, words.judged), ...entries),
        group(null,
          words.unjudged ? element("p", {}, words.unjudged) : null,
          words.close ? sample([block({ class: "cell grey pale" })], words.close) : null,
          words.limit ? sample([hatching(id), block({ fill: `url(#${id})`, class: "framed" })], words.limit) : null,
          blank),
        chosen].filter(Boolean));
  }

  colourBar() {
    const colours = this.colours();
    const place = (value) => 250 - 240 * colours.fraction(value);
    const made = [];
    for (let step = 0; step < 48; step++) {
      made.push(shape("rect", { x: 4, y: 245 - 5 * step, width: 22, height: 5.5, fill: this.shade((step + 0.5) / 48) }));
    }
    for (const { value, label } of colours.ticks(7, this.map.z.ladders).major) {
      made.push(shape("path", { class: "tick", d: `M26,${place(value)}h5` }), shape("text", { x: 35, y: place(value) + 4.5 }, label));
    }
    const limit = this.map.limit?.value;
    if (limit >= colours.low && limit <= colours.high) made.push(shape("path", { class: "limit solid", d: `M0,${place(limit)}h30` }));
    return made;
  }
}

/** Whether values are so far apart that an even axis would hide the small ones. */
function isWide(series) {
  const values = series.flatMap(({ points }) => points.map((point) => point.y));
  const [least, most] = [Math.min(...values), Math.max(...values)];
  return least > 0 && most > 30 * least;
}

function hatching(id) {
  return shape("pattern", { id, width: 6.4, height: 6.4, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    shape("path", { class: "hatch", d: "M0,0V6.4" }));
}
