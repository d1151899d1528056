// Sliders for the keys of a study and fields for its sweeps, in step with their places in its text.

import { element } from "./elements.js";

const STEPS = 400;

/** A range wider than this is that of all that is allowed, not of what one would try. */
const WIDEST = 1e6;

const round = (number) => Number(number.toPrecision(3));

/** The range of a slider: its limits where they are near enough, else a decade on each side of the value. */
export function rangeOf({ number, low, high, is_whole: isWhole }) {
  const isNear = low !== null && high !== null && (low > 0 ? high / low <= WIDEST : high - low <= 1000 * Math.abs(number || high - low));
  if (isNear) return { low, high, isLog: low > 0 && high / low > 100 };
  if (number > 0) {
    const [from, to] = [Math.max(low ?? 0, number / 10), Math.min(high ?? Infinity, number * 10)];
    return isWhole ? { low: Math.max(low ?? 1, 1), high: Math.ceil(to), isLog: false } : { low: from, high: to, isLog: from > 0 };
  }
  const reach = Math.abs(number) * 2 || 10;
  return { low: low ?? (number < 0 ? -reach : 0), high: Math.min(high ?? Infinity, reach), isLog: false };
}

const positionOf = (number, { low, high, isLog }) => STEPS * (isLog ? Math.log(number / low) / Math.log(high / low) : (number - low) / (high - low));

function numberAt(position, { low, high, isLog }, isWhole) {
  const part = position / STEPS;
  const number = isLog ? low * (high / low) ** part : low + (high - low) * part;
  return isWhole ? Math.round(number) : Math.min(high, Math.max(low, round(number)));
}

export class Sliders {
  /** `change(span, text)` replaces a part of the study. */
  constructor(host, change) {
    this.host = host;
    this.change = change;
    this.rows = new Map();
  }

  /** Takes over the keys of a text; a slider that is there stays, so that it keeps the focus. */
  set(keys) {
    const before = this.rows;
    this.rows = new Map(keys.map((key) => [key.name, before.get(key.name) ?? this.#row(key)]));
    const nodes = keys.map((key) => this.rows.get(key.name).node);
    if (nodes.length !== this.host.children.length || nodes.some((node, at) => node !== this.host.children[at])) this.host.replaceChildren(...nodes);
    keys.forEach((key) => this.#update(this.rows.get(key.name), key));
  }

  clear() {
    this.set([]);
  }

  #row(key) {
    const id = `slider-${key.name}`;
    const input = element("input", { type: "range", id, min: "0", max: STEPS, step: "1" });
    const output = element("output", { for: id });
    const label = element("label", { for: id, title: key.name }, key.label || key.name);
    const row = { node: element("div", { class: "slider" }, label, output, input), input, output, range: rangeOf(key), key };
    input.addEventListener("input", () => this.#moved(row));
    return row;
  }

  /** After the text was changed elsewhere, places are unknown until it is read again. */
  disable() {
    this.rows.forEach(({ input }) => {
      input.disabled = true;
    });
  }

  #update(row, key) {
    row.key = key;
    row.input.disabled = false;
    const { low, high } = row.range;
    if (key.number < low || key.number > high || key.unit !== row.unit) row.range = rangeOf(key);
    row.unit = key.unit;
    if (document.activeElement !== row.input || numberAt(row.input.value, row.range, key.is_whole) !== key.number) row.input.value = positionOf(key.number, row.range);
    this.#label(row, key.value);
  }

  #label({ input, output }, value) {
    output.textContent = value;
    input.setAttribute("aria-valuetext", value);
  }

  #moved(row) {
    const { key } = row;
    const number = numberAt(Number(row.input.value), row.range, key.is_whole);
    const value = key.unit ? `${number} ${key.unit}` : `${number}`;
    this.#label(row, value);
    const [from, to] = key.span;
    const length = this.change(key.span, value);
    // Until the text is read again, what stands behind has moved.
    const moved = length - (to - from);
    key.span = [from, from + length];
    for (const { key: other } of this.rows.values()) if (other.span[0] >= to && other !== key) other.span = other.span.map((at) => at + moved);
  }
}

/** Fields with the values of sweeps, as they are written. */
export class Sweeps {
  /** `change(span, text)` replaces a part of the study. */
  constructor(host, change) {
    this.host = host;
    this.change = change;
    this.rows = [];
  }

  /** Takes over the sweeps of a text; the field that has the focus keeps it. */
  set(sweeps, text) {
    if (sweeps.map(({ key }) => key).join() !== this.rows.map(({ key }) => key).join()) {
      this.rows = sweeps.map(({ key }) => this.#row(key));
      this.host.replaceChildren(...this.rows.map(({ node }) => node));
    }
    sweeps.forEach(({ label, values, span }, at) => {
      const row = this.rows[at];
      row.span = span;
      row.label.textContent = values.length === 1 ? `${label}: 1 value` : `${label}: ${values.length} values`;
      row.area.disabled = false;
      if (document.activeElement === row.area) return;
      row.area.value = text.slice(...span);
      row.area.rows = row.area.value.split("\n").length;
    });
  }

  clear() {
    this.set([], "");
  }

  /** After the text was changed elsewhere than in the field `area`, places are unknown until it is read again. */
  disable(area = null) {
    this.rows.forEach((row) => {
      row.area.disabled = row.area !== area;
    });
  }

  #row(key) {
    const id = `sweep-${key}`;
    const label = element("label", { for: id, title: key });
    const area = element("textarea", { id, spellcheck: "false", autocapitalize: "off", autocomplete: "off" });
    const row = { key, node: element("div", { class: "sweep" }, label, area), label, area, span: [0, 0] };
    area.addEventListener("input", () => {
      this.disable(area);
      row.span = [row.span[0], row.span[0] + this.change(row.span, area.value)];
    });
    return row;
  }
}
