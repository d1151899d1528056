// Charts of curves y(x): bands, closed forms, laws and limit, a legend that switches them, and what is read off.

/** An axis as it is, or linear where a logarithmic one has a place for none of its values. */
function placed(axis, values) {
  const hidden = axis.scale === "log" && values.length > 0 && !values.some((value) => value > 0);
  return hidden ? { ...axis, scale: "linear" } : axis;
}

/** Dashes, markers and colours by style, and how many points have markers; the page gives them. */
let looks;

/** The styles of a series, by which the legend finds what is drawn of it. */
const styles = (series) => ({ "data-colour": series.colour, "data-dash": series.dash });

const styled = (list, style) => list[style % list.length];

class Curves {
  constructor(figure) {
    this.figure = figure;
    const points = figure.series.flatMap((series) => series.points);
    this.x = placed(figure.x, points.map((point) => point.x));
    this.y = placed(figure.y, points.map((point) => point.y));
    this.off = new Set();
    this.hasLaws = figure.series.some((series) => series.law.length > 0);
    this.ownDashes = figure.dashes.entries.length > 0;
    this.named = figure.x.names.length > 0;
    // Names up the axis y, whose points no line joins.
    this.rows = figure.y.names?.length > 0;
    // The closed form of the only series has a colour of its own.
    this.alone = figure.colours.entries.length === 0;
    if (figure.is_panel) this.height = (width) => Math.min(Math.max(0.28 * width, 150), 220);
  }

  /** Whether an axis has values that a logarithmic one tells better apart. */
  canBeLog(axis) {
    const values = this.figure.series.flatMap((series) => series.points.map((point) => point[axis])).filter((value) => value !== null);
    return this[axis].scale === "log" || (values.every((value) => value >= 0) && Math.max(...values) > 4 * Math.min(...values));
  }

  /** Whether something is switched on: `colour 2`, `bands`. */
  on(key) {
    return !this.off.has(key);
  }

  series() {
    return this.figure.series.filter((series) => this.on(`colour ${series.colour}`) && this.on(`dash ${series.dash}`));
  }

  name(series) {
    const of = ({ entries }, style) => entries.find((entry) => entry.style === style)?.name;
    const { colours, dashes } = this.figure;
    return [of(colours, series.colour), of(dashes, series.dash)].filter((name) => name !== undefined).join(", ");
  }

  dashOf(series) {
    return this.ownDashes ? series.dash : series.colour;
  }

  laws() {
    return this.figure.laws.flatMap((law, at) => (this.on(`law ${at}`) ? law.lines.map((line) => ({ line, at })) : []));
  }

  // As wide as points and laws, as high as the points and, within reason, what stands beside them.
  ranges(xLog, yLog) {
    const { figure } = this;
    const shows = (x, y) => Range.shows(xLog, x) && Range.shows(yLog, y);
    const points = this.series().flatMap((series) => series.points).filter(({ x, y }) => shows(x, y));
    const lines = this.laws().flatMap(({ line }) => line.points).filter(([x, y]) => shows(x, y));
    const across = [...points.map((point) => point.x), ...lines.map((place) => place[0])];
    const x = figure.x.whole && !xLog ? Range.counting(across) : Range.around(xLog, across);
    let [low, high] = [Infinity, -Infinity];
    for (const point of points) [low, high] = [Math.min(low, point.y), Math.max(high, point.y)];
    const room = Math.max(high - low, 0.5 * Math.max(Math.abs(low), Math.abs(high)));
    const [from, to] = points.length === 0 ? [-Infinity, Infinity]
      : yLog ? [low / 10, high * 10] : [low - room, high + room];
    const others = lines.map((place) => place[1]);
    if (this.on("bands")) {
      for (const { band } of points) if (band) others.push(band[0], band[1]);
    }
    if (this.on("lines")) {
      for (const series of this.series()) for (const place of series.law) others.push(place[1]);
    }
    const near = others.filter((value) => Range.shows(yLog, value)).map((value) => Math.min(Math.max(value, from), to));
    const limit = figure.limit && this.on("limit") ? this.limits() : [];
    const whole = function* () {
      for (const point of points) yield point.y;
      yield* near;
      yield* limit;
    };
    const beside = (axis, range) => (axis.names?.length > 0 ? new Range(false, 0.5, axis.names.length + 0.5) : range);
    return { x: beside(figure.x, x), y: beside(figure.y, Range.around(yLog, whole())) };
  }

  draw(plot, under, over) {
    const { figure } = this;
    this.shadeRanges(plot, under);
    for (const { line, at } of this.laws()) {
      const colour = line.colour === null ? "grey" : `c${line.colour % 8}`;
      const look = figure.laws[at].is_area ? { class: `band ${colour}` } : { class: `law ${colour}`, "stroke-dasharray": styled(looks.broad_dashes, at) };
      this.line(plot, under, line.points, look);
      // A thin line for reference has its label at its end within the frame.
      const end = line.points.filter(([x, y]) => plot.shows(x, y)).map(([x, y]) => [plot.across(x), plot.down(y)])
        .findLast((place) => plot.inFrame(place) && place[1] > plot.frame.top + 14);
      if (end && colour === "grey" && figure.laws[at].lines.length === 1 && !plot.small) {
        over.append(shape("text", { class: "law-label", x: end[0], y: end[1] - 5, "text-anchor": "end" }, figure.laws[at].label));
      }
    }
    const series = this.series();
    if (this.on("bands")) series.forEach((each) => this.bands(plot, under, each));
    figure.parts.lines.forEach((part, at) => {
      const look = { class: `part c${part.colour % 8}`, "stroke-dasharray": styled(looks.thin_dashes, at) };
      if (this.on(`part ${at}`)) this.line(plot, under, part.points, look);
    });
    for (const each of series) {
      const look = { ...styles(each), class: `curve c${each.colour % 8}`, "stroke-dasharray": styled(looks.dashes, this.dashOf(each)) };
      if (this.named) {
        if (this.on("lines")) this.levels(plot, under, each.law, { ...look, "stroke-dasharray": null });
        continue;
      }
      const joined = figure.joined ?? each.law.length < 2;
      if (!joined && this.alone) look.class = `curve c${(each.colour + 1) % 8}`;
      const points = joined ? each.points.map(({ x, y }) => [x, y]) : each.law;
      if (!this.rows && (joined ? this.on("points") : this.on("lines"))) this.line(plot, under, points, look);
    }
    if (this.on("points")) series.forEach((each) => this.markers(plot, over, each));
    // Its label is over the markers, and where it covers least.
    const taken = figure.limit && this.on("limit") ? this.limit(plot, under, over) : null;
    this.marks(plot, over, taken ? [taken] : []);
    if (figure.slopes && plot.log.x && plot.log.y) this.slopes(plot, over);
    if (!series.some((each) => each.points.some(({ x, y }) => plot.shows(x, y)))) {
      const { left, right, top, bottom } = plot.frame;
      const why = series.length === 0 ? "all curves are switched off" : "no value has a place on these axes";
      over.append(shape("text", { class: "nothing", x: (left + right) / 2, y: (top + bottom) / 2, "text-anchor": "middle" }, why));
    }
  }

  /** A line, interrupted where the axes cannot show it. */
  line(plot, group, points, look) {
    let [path, drawing] = ["", false];
    for (const [x, y] of points) {
      const shown = plot.shows(x, y);
      if (shown) path += `${drawing ? "L" : "M"}${plot.across(x)},${plot.down(y)}`;
      drawing = shown;
    }
    if (path) group.append(shape("path", { fill: "none", d: path, ...look }));
  }

  /** Values of what stands side by side, which no line joins. */
  levels(plot, group, points, look) {
    const bar = ([x, y]) => `M${plot.across(x) - 12},${plot.down(y)}h24`;
    const d = points.filter(([x, y]) => plot.shows(x, y)).map(bar).join("");
    if (d) group.append(shape("path", { fill: "none", d, ...look }));
  }

  /** Whether each interval is a bar of its own: of names, and of a few points beside a closed form. */
  hasBars(series) {
    return this.named || (series.law.length > 1 && series.points.length <= 15);
  }

  bands(plot, group, series) {
    const colour = `c${series.colour % 8}`;
    let [areas, bars] = ["", ""];
    const flush = (run) => {
      const place = (x, y) => `${plot.across(x)},${plot.down(y)}`;
      if (run.length === 1) {
        const { x, band: [low, high] } = run[0];
        const [at, lower, upper] = [plot.across(x), plot.down(low), plot.down(high)];
        bars += `M${at},${lower}V${upper}M${at - 5},${lower}h10M${at - 5},${upper}h10`;
      } else if (run.length > 1) {
        const lower = run.map(({ x, band }) => place(x, band[0]));
        const upper = run.map(({ x, band }) => place(x, band[1])).reverse();
        areas += `M${[...lower, ...upper].join("L")}Z`;
      }
    };
    let run = [];
    for (const point of series.points) {
      if (this.hasBars(series)) flush(run.splice(0));
      if (point.band && plot.shows(point.x, point.y)) run.push(point);
      else {
        flush(run);
        run = [];
      }
    }
    flush(run);
    if (areas) group.append(shape("path", { ...styles(series), class: `band ${colour}`, d: areas }));
    if (bars) group.append(shape("path", { ...styles(series), class: `bar ${colour}`, d: bars }));
  }

  /** The values at which a line shows the limit: it limits the magnitude, so that below 0 there is a second one. */
  limits() {
    const { value } = this.figure.limit;
    const signed = this.figure.series.some((series) => series.points.some((point) => point.y < 0));
    return signed ? [value, -value] : [value];
  }

  limit(plot, under, over) {
    const { value, label } = this.figure.limit;
    const { left, right } = plot.frame;
    for (const side of this.limits()) {
      if (Range.shows(plot.log.y, side)) under.append(shape("path", { class: "limit", d: `M${left},${plot.down(side)}H${right}` }));
    }
    const y = plot.down(value);
    if (!Range.shows(plot.log.y, value) || !plot.inFrame([left, y])) return null;
    const [width, height] = [textWidth(label, plot.small ? 11 : 13), plot.small ? 11 : 13];
    // Below the line, or above it, at the place along it where the label covers least of the curves.
    const { top, bottom } = plot.frame;
    const places = [y - 7, y + height + 4].filter((base) => base - height > top && base < bottom - 2);
    const starts = [0, 1, 0.5, 0.25, 0.75].map((part) => left + 10 + part * Math.max(right - width - left - 20, 0));
    const lines = this.series().map((series) => this.traced(plot, series));
    const covered = (x, base) => {
      const within = ([px, py]) => px > x - 8 && px < x + width + 8 && py > base - height - 5 && py < base + 5;
      return lines.flat().filter(within).length;
    };
    const all = (places.length > 0 ? places : [y - 7]).flatMap((base) => starts.map((x) => ({ x, base, covered: covered(x, base) })));
    const { x, base } = all.reduce((best, one) => (one.covered < best.covered ? one : best));
    over.append(shape("text", { class: "limit-label", x, y: base }, label));
    return [x - 3, base - height, x + width + 3, base + 4];
  }

  /** Places along a curve in px, close enough to find what a text would cover. */
  traced(plot, series) {
    const places = series.points.filter(({ x, y }) => plot.shows(x, y)).map(({ x, y }) => [plot.across(x), plot.down(y)]);
    const between = ([x, y], at) => {
      const [x0, y0] = places[Math.max(at - 1, 0)];
      const steps = Math.min(Math.max(Math.ceil(Math.hypot(x - x0, y - y0) / 6), 1), 200);
      return Array.from({ length: steps }, (_, step) => [x0 + ((x - x0) * (step + 1)) / steps, y0 + ((y - y0) * (step + 1)) / steps]);
    };
    return places.flatMap(between);
  }

  markers(plot, group, series) {
    const points = series.points.filter(({ x, y }) => plot.shows(x, y));
    const inside = points.map(({ x, y }) => [plot.across(x), plot.down(y)]).filter((place) => plot.inFrame(place));
    const step = inside.length > looks.most_marked && !this.hasLaws ? Math.ceil(inside.length / looks.marked) : 1;
    const radius = Math.min(Math.max(((130 * step) / inside.length) * (plot.width / 700), 1.5), 4.2);
    let path = "";
    for (let at = 0; at < inside.length; at += step) path += markerPath(this.dashOf(series), radius, inside[at]);
    // The rims of small ones would hide each other.
    const rim = radius < 2.4 ? " rimless" : "";
    if (path) group.append(shape("path", { ...styles(series), class: `marker c${series.colour % 8}${rim}`, d: path }));
  }

  // What the answer names.

  shadeRanges(plot, group) {
    const { top, bottom } = plot.frame;
    for (const { range } of this.on("ranges") ? this.figure.marks ?? [] : []) {
      if (!range || range.some((x) => !Range.shows(plot.log.x, x))) continue;
      const [from, to] = range.map((x) => plot.across(x));
      group.append(shape("rect", { class: "good", x: from, y: top, width: to - from, height: bottom - top }));
    }
  }

  /** The marks with their labels, which cover as little as possible; a label without room is left out. */
  marks(plot, group, labelled) {
    const { left, top, right, bottom } = plot.frame;
    const size = plot.small ? 11 : 13;
    const shown = (this.figure.marks ?? []).filter(({ place: [x, y] }) => plot.shows(x, y))
      .map((mark) => ({ ...mark, at: [plot.across(mark.place[0]), plot.down(mark.place[1])] })).filter(({ at }) => plot.inFrame(at));
    if (shown.length === 0) return;
    const made = shape("g", { class: "answer" });
    const drops = shown.filter((mark) => mark.shape === "crossing").map(({ at: [x, y] }) => `M${x},${y}V${bottom}`);
    if (drops.length > 0) made.append(shape("path", { class: "drop", d: drops.join("") }));
    const styles = { crossing: 0, extremum: 3, coefficient: 1 };
    const dots = shown.filter((mark) => mark.shape in styles).map((mark) => markerPath(styles[mark.shape], 5, mark.at));
    made.append(shape("path", { class: "dot", d: dots.join("") }));
    const curves = this.series().flatMap((series) => this.traced(plot, series));
    for (const { at: [x0, y0], label, shape: mark } of shown.filter((mark) => mark.label)) {
      const width = textWidth(label, size) * 1.08;
      const beside = { left: [[-9, 4.5, "end"], [0, -14, "start"]], right: [[9, 4.5, "start"], [0, -14, "end"]] }[mark] ?? BESIDE;
      const places = beside.map(([across, down, anchor]) => {
        const [x, y] = [x0 + across, y0 + down];
        const from = anchor === "start" ? x : anchor === "end" ? x - width : x - width / 2;
        return { x, y, anchor, box: [from - 3, y - size, from + width + 3, y + 4] };
      });
      const free = places.filter(({ box: [x1, y1, x2, y2] }) => x1 >= left && y1 >= top && x2 <= right && y2 <= bottom
        && !labelled.some((other) => x1 < other[2] && other[0] < x2 && y1 < other[3] && other[1] < y2));
      if (free.length === 0) continue;
      const covered = ({ box: [x1, y1, x2, y2] }) => {
        const within = ([x, y]) => x >= x1 && x <= x2 && y >= y1 && y <= y2;
        // A label nearer to another mark would name that one.
        const far = ([x, y]) => Math.hypot(x - (x1 + x2) / 2, y - (y1 + y2) / 2);
        return curves.filter(within).length + 500 * shown.filter(({ at }) => far(at) < far([x0, y0])).length;
      };
      const best = free.reduce((one, other) => (covered(other) < covered(one) ? other : one));
      labelled.push(best.box);
      made.append(shape("text", { class: "mark-label", x: best.x, y: best.y, "text-anchor": best.anchor }, label));
    }
    group.append(made);
  }

  /** Short lines with the slopes of the noise terms, in the lower left corner. */
  slopes(plot, group) {
    const { left, right, top, bottom } = plot.frame;
    const perDecade = (size, range) => size / Math.log10(range.high / range.low);
    const [across, up] = [perDecade(right - left, plot.ranges.x), perDecade(bottom - top, plot.ranges.y)];
    const [x, y] = [left + 14, bottom - (plot.small ? 50 : 72)];
    const made = shape("g", { class: "slopes" });
    for (const [slope, label] of [[-1, "−1"], [-0.5, "−½"], [0, "0"], [0.5, "+½"], [1, "+1"]]) {
      const length = (plot.small ? 42 : 60) / Math.hypot(across, slope * up);
      const [dx, dy] = [length * across, -length * slope * up];
      made.append(shape("path", { d: `M${x},${y}l${dx},${dy}` }), shape("text", { x: x + dx + 3, y: y + dy + 4 }, label));
    }
    group.append(made);
  }

  /** The numbers of the chart, a row for each point. */
  csv() {
    const { figure } = this;
    const rows = this.figure.series.flatMap((series) => {
      const law = new Map(series.law);
      return series.points.map(({ x, y, band }) => [this.named ? axisValue(this.x, x) : x, this.name(series), y, ...(band ?? ["", ""]), law.get(x) ?? ""]);
    });
    return csvOf([[axisTitle(this.x), "curve", axisTitle(this.y), "lower", "upper", figure.lines || "closed form"], ...rows]);
  }

  // Reading values.

  /** The point nearest to a place. */
  near(plot, x, y) {
    let [best, distance] = [null, Infinity];
    for (const series of this.series()) {
      series.points.forEach((point, at) => {
        if (!plot.shows(point.x, point.y)) return;
        const place = [plot.across(point.x), plot.down(point.y)];
        const apart = Math.hypot(place[0] - x, 0.6 * (place[1] - y));
        if (apart < distance && plot.inFrame(place)) [best, distance] = [{ series, at }, apart];
      });
    }
    return best && this.told(plot, best);
  }

  /** Along a curve, or to the next one. */
  step(plot, way) {
    // Only what is in the frame, of which a part may be enlarged.
    const isShown = ({ x, y }) => plot.shows(x, y) && plot.inFrame([plot.across(x), plot.down(y)]);
    const all = this.series().filter((series) => series.points.some(isShown));
    if (all.length === 0) return null;
    const now = plot.told?.found ?? { series: all[0], at: -1 };
    const places = (series) => series.points.map((_, at) => at).filter((at) => isShown(series.points[at]));
    if (way === "Left" || way === "Right") {
      const order = places(now.series);
      const next = order[order.indexOf(now.at) + (way === "Right" ? 1 : -1)];
      return this.told(plot, { series: now.series, at: next ?? (now.at < 0 ? order[0] : now.at) });
    }
    const series = all[(all.indexOf(now.series) + (way === "Down" ? 1 : all.length - 1)) % all.length];
    const x = now.at < 0 ? plot.ranges.x.low : now.series.points[now.at].x;
    const apart = (at) => Math.abs(plot.across(series.points[at].x) - plot.across(x));
    return this.told(plot, { series, at: places(series).reduce((a, b) => (apart(b) < apart(a) ? b : a)) });
  }

  told(plot, found) {
    const { x, y } = found.series.points[found.at];
    const place = [plot.across(x), plot.down(y)];
    const { top, bottom } = plot.frame;
    const marks = [
      shape("path", { class: "cross", d: `M${place[0]},${top}V${bottom}` }),
      shape("circle", { class: `ring c${found.series.colour % 8}`, cx: place[0], cy: place[1], r: 7 }),
    ];
    return { found, place, marks, text: () => this.text(found), again: (anew) => this.told(anew, found) };
  }

  /** What is read off as a pinned reading. */
  reading({ series, at }) {
    const { x, y } = series.points[at];
    return { name: this.name(series) || this.y.label, x, y, colour: series.colour };
  }

  /** All curves at the x that is read off, the one pointed at first. */
  text(found) {
    const { x, key } = found.series.points[found.at];
    const rows = this.series().map((series) => ({ series, point: series.points.find((point) => point.x === x) }))
      .filter(({ point }) => point && Number.isFinite(point.y));
    const first = (a, b) => (b.series === found.series) - (a.series === found.series);
    const shown = rows.sort(first).slice(0, 9);
    const unit = this.y.unit;
    const lines = shown.map(({ series, point }) => {
      const law = series.law.find((place) => place[0] === x);
      const value = element("b", {}, this.rows ? axisValue(this.y, Math.round(point.y)) : measured(point.y, unit));
      const band = point.band ? ` ${this.figure.bands || "interval"}: ${significant(point.band[0], READ)} … ${significant(point.band[1], READ)}` : "";
      return element("tr", { class: series === found.series ? "first" : null },
        element("td", {}, element("i", { class: `swatch c${series.colour % 8}` })),
        element("td", {}, this.name(series) || this.y.label),
        element("td", {}, value, element("small", {}, band, law && Number.isFinite(law[1]) ? ` ${this.figure.lines || "closed form"}: ${significant(law[1], READ)}` : "")));
    });
    const more = rows.length > shown.length ? element("p", {}, `and ${rows.length - shown.length} more`) : null;
    return [element("p", { class: "at" }, axisValue(this.x, x), key === undefined ? "" : ` (${axisValue(this.figure.key, key)})`), element("table", {}, ...lines), more].filter(Boolean);
  }

  // The legend.

  legend(plot) {
    const { figure } = this;
    const group = (title, entries) => (entries.length === 0 ? null
      : element("div", { class: "group" }, title ? element("h4", {}, title) : null, ...entries));
    const entry = (key, sample, name) => this.entry(plot, key, sample, name);
    const curve = (look, style) => this.named ? [sampleMarker(look.class, style)] : [sampleLine({ ...look, "stroke-dasharray": styled(looks.dashes, style) }), sampleMarker(look.class, style)];
    const colours = figure.colours.entries.map(({ style, name }) => entry(`colour ${style}`,
      this.ownDashes ? [sampleLine({ class: `thick c${style % 8}` })] : curve({ class: `curve c${style % 8}` }, style), name));
    const dashes = figure.dashes.entries.map(({ style, name }) => entry(`dash ${style}`, curve({ class: "curve grey" }, style), name));
    const laws = figure.laws.map((law, at) => {
      const [first, ...others] = law.lines.map((line) => line.colour);
      const one = first !== null && others.every((other) => other === first);
      const colour = one ? `c${first % 8}` : "grey";
      const sample = law.is_area ? sampleBand(colour) : sampleLine({ class: `law ${colour}`, "stroke-dasharray": styled(looks.broad_dashes, at) });
      return entry(`law ${at}`, [sample], law.label);
    });
    const parts = figure.parts.lines.map((part, at) => entry(`part ${at}`,
      [sampleLine({ class: `part c${part.colour % 8}`, "stroke-dasharray": styled(looks.thin_dashes, at) })], part.label));
    const reading = [];
    if (figure.points) reading.push(entry("points", [sampleMarker("curve grey", 0)], figure.points));
    const lines = this.alone ? `curve c${(figure.series[0]?.colour ?? 0) + 1}` : "curve grey";
    if (this.hasLaws) reading.push(entry("lines", [sampleLine({ class: lines })], figure.lines));
    if (figure.series.some((series) => series.points.some((point) => point.band))) {
      const sample = figure.series.every((series) => this.hasBars(series)) ? sampleBar("grey") : sampleBand("grey");
      reading.push(entry("bands", [sample], figure.bands || "interval"));
    }
    if (figure.marks?.some(({ range }) => range)) reading.push(entry("ranges", [shape("rect", { class: "good", x: 0, y: 4, width: 36, height: 10 })], "within 4 % of the marked best"));
    if (figure.limit) reading.push(entry("limit", [sampleLine({ class: "limit" })], figure.limit.label));
    const chosen = figure.chosen.map((text) => element("p", {}, text));
    return element("div", { class: "legend" }, group(figure.colours.title, colours), group(figure.dashes.title, dashes), group(null, laws),
      group(null, reading), group(figure.parts.title, parts), group("shown", chosen));
  }

  entry(plot, key, sample, name) {
    const [kind] = key.split(" ");
    const siblings = () => [...made.parentElement.querySelectorAll("button")];
    const made = button("", "Switch off or on; double click, or Shift and Enter, for this one alone", (event) => {
      if (event.shiftKey) {
        alone();
        return;
      }
      if (this.on(key)) this.off.add(key);
      else this.off.delete(key);
      update();
    }, true);
    const update = () => {
      for (const each of siblings()) each.setAttribute("aria-pressed", this.on(each.dataset.key));
      plot.tell(null);
      plot.render();
    };
    const alone = () => {
      if (!["colour", "dash", "law", "part"].includes(kind)) return;
      const others = siblings().map((each) => each.dataset.key).filter((other) => other !== key);
      const isAlone = others.every((other) => !this.on(other));
      for (const other of others) isAlone ? this.off.delete(other) : this.off.add(other);
      this.off.delete(key);
      update();
    };
    made.addEventListener("dblclick", alone);
    // The others recede while one is pointed at.
    const recede = (isOver) => plot.picture.querySelectorAll(`[data-${kind}]`).forEach((each) => {
      each.style.opacity = isOver && each.dataset[kind] !== key.split(" ")[1] ? 0.15 : "";
    });
    made.addEventListener("pointerenter", () => recede(true));
    made.addEventListener("pointerleave", () => recede(false));
    made.dataset.key = key;
    made.append(shape("svg", { class: "sample", viewBox: "0 0 36 18", "aria-hidden": "true" }, ...sample), element("span", {}, name));
    return made;
  }
}

function sampleLine(look) {
  return shape("path", { fill: "none", d: "M0,9H36", ...look });
}

function sampleBand(colour) {
  return shape("rect", { class: `band ${colour}`, x: 0, y: 4, width: 36, height: 10 });
}

function sampleBar(colour) {
  return shape("path", { class: `bar ${colour}`, d: "M18,2V16M13,2h10M13,16h10" });
}

function sampleMarker(look, style) {
  return shape("path", { class: look.replace("curve", "marker"), d: markerPath(style, 4.2, [18, 9]) });
}

/** Where a label may be beside its mark, the best first: steps to the right, steps down, and its anchor. */
const BESIDE = [[9, -8, "start"], [-9, -8, "end"], [9, 18, "start"], [-9, 18, "end"], [0, -14, "middle"], [0, 24, "middle"], [9, -26, "start"], [-9, -26, "end"]];

/** A marker as a path: a circle where its style has no corners. */
function markerPath(style, radius, [x, y]) {
  const corners = styled(looks.markers, style);
  if (corners.length === 0) return `M${x - radius},${y}a${radius},${radius} 0 1 0 ${2 * radius},0a${radius},${radius} 0 1 0 ${-2 * radius},0Z`;
  const place = ([dx, dy]) => `${Math.round(100 * (x + radius * dx)) / 100},${Math.round(100 * (y + radius * dy)) / 100}`;
  return `M${corners.map(place).join("L")}Z`;
}
