// From numbers to places on an axis, and which of the given ticks it has.

/** A stretch of numbers, divided by powers of ten or evenly. */
class Range {
  constructor(log, low, high) {
    Object.assign(this, { log, low, high });
  }

  /** Whether an axis with this scale has a place for the value. */
  static shows(log, value) {
    return Number.isFinite(value) && (!log || value > 0);
  }

  /** A range with all values that the scale can show, and a margin. */
  static around(log, values) {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) {
      if (Range.shows(log, value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    if (low > high) return log ? new Range(true, 1, 10) : new Range(false, 0, 1);
    if (log) {
      const decades = Math.log10(high / low);
      const factor = 10 ** (decades < 1e-6 ? 0.5 : 0.04 * decades);
      return new Range(true, low / factor, high * factor);
    }
    const largest = Math.max(Math.abs(low), Math.abs(high));
    const span = high - low;
    if (largest === 0) return new Range(false, -1, 1);
    if (span <= 1e-12 * largest) return new Range(false, low - 0.5 * largest, high + 0.5 * largest);
    if (low >= 0 && low <= 0.3 * high) return new Range(false, 0, 1.05 * high);
    if (high <= 0 && high >= 0.3 * low) return new Range(false, 1.05 * low, 0);
    return new Range(false, low - 0.05 * span, high + 0.05 * span);
  }

  /** A range with counts, which does not extend to 0 merely because 0 is near. */
  static counting(values) {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
    if (!(low > 0 && low < high)) return Range.around(false, values);
    const margin = 0.05 * (high - low);
    return new Range(false, Math.max(low - margin, 0), high + margin);
  }

  coordinate(value) {
    return this.log ? Math.log10(value) : value;
  }

  /** Where a value lies: 0 at the lower end, 1 at the upper. What has no place lies far below. */
  fraction(value) {
    if (this.log && value <= 0) return -20;
    const [low, high] = [this.coordinate(this.low), this.coordinate(this.high)];
    return Math.min(Math.max((this.coordinate(value) - low) / (high - low), -20), 20);
  }

  /** The value at a fraction. */
  value(fraction) {
    const [low, high] = [this.coordinate(this.low), this.coordinate(this.high)];
    const at = low + fraction * (high - low);
    return this.log ? 10 ** at : at;
  }

  /** The part between two fractions; no narrower than numbers can tell apart. */
  part(from, to) {
    const part = new Range(this.log, this.value(from), this.value(to));
    const apart = part.high - part.low > 1e-9 * Math.max(Math.abs(part.low), Math.abs(part.high));
    return apart && Number.isFinite(part.high) && (!part.log || part.low > 0) ? part : this;
  }

  /** Values with labels, at most about so many, and values between them without: of the `ladders` that the page gives, the first that suit. */
  ticks(most, ladders) {
    const { levels, steps, in_full: [leastFull, mostFull] } = this.log ? ladders.log : ladders.linear;
    for (const { major, minor } of levels) {
      const held = major.filter(([value]) => this.holds(value));
      if (held.length < Math.min(3, most) || held.length > most || !this.isSpread(held.map(([value]) => value))) continue;
      // The given labels are those of a wider axis.
      const full = held.every(([value]) => value >= leastFull && value <= mostFull);
      const labelled = held.map(([value, label]) => ({ value, label: full ? significant(value) : label }));
      return { major: labelled, minor: minor.filter((value) => this.holds(value)) };
    }
    const least = ((this.high - this.low) / most) * (1 - 1e-9);
    const found = steps.findIndex((each) => each.step >= least);
    const at = found < 0 ? steps.length - 1 : found;
    const major = this.multiples(steps[at]);
    return { major: this.log && major.length < 3 && at > 0 ? this.multiples(steps[at - 1]) : major, minor: [] };
  }

  /** The multiples of a step that it holds, as ticks. */
  multiples({ step, shown, decimals, power }) {
    const major = [];
    for (let i = Math.ceil(this.low / step - 1e-9); i * step <= this.high + 1e-9 * step; i++) {
      major.push({ value: i * step, label: i === 0 ? "0" : `${minus((i * shown).toFixed(decimals))}${power}` });
    }
    return major;
  }

  /** Whether values leave no more than three fifths of the axis without one. */
  isSpread(values) {
    const places = [0, ...values.map((value) => this.fraction(value)), 1];
    return places.every((place, at) => at === 0 || place - places[at - 1] <= 0.6);
  }

  /** The places 1, 2, 3, … of names that it holds, as ticks. */
  names(names) {
    const major = names.map((label, at) => ({ value: at + 1, label })).filter(({ value }) => this.holds(value));
    return { major, minor: [], named: true };
  }

  holds(value) {
    const at = this.fraction(value);
    return at >= -1e-9 && at <= 1 + 1e-9;
  }
}
