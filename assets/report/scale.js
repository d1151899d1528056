// From numbers to places on an axis, and the ticks of it: as the pictures beside the page have them.

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

  /** Values with labels, at most about so many, and values between them without. */
  ticks(most, whole) {
    return this.log ? this.logTicks(most) : this.linearTicks(most, whole);
  }

  /** The places 1, 2, 3, … of names that it holds, as ticks. */
  names(names) {
    const major = names.map((label, at) => ({ value: at + 1, label })).filter(({ value }) => this.holds(value));
    return { major, minor: [], named: true };
  }

  logTicks(most) {
    const [first, last] = [this.low, this.high].map((end) => Math.floor(Math.log10(end)));
    const digits = (counts) => {
      const all = [];
      for (let exponent = first; exponent <= last; exponent++) {
        for (const count of counts) all.push({ count, exponent });
      }
      return all.filter((tick) => this.holds(decimal(tick)));
    };
    const every = digits([1, 2, 3, 4, 5, 6, 7, 8, 9]);
    const decades = digits([1]);
    if (decades.length > most) {
      const stride = Math.ceil(decades.length / most);
      return logLabels(decades.filter((tick) => tick.exponent % stride === 0), decades);
    }
    if (Math.log10(this.high / this.low) >= 2 && decades.length > 2) return logLabels(decades, every);
    const labels = [digits([1, 2, 5]), every].find((ticks) => ticks.length >= 3 && ticks.length <= most + 2);
    return labels ? logLabels(labels, every) : this.linearTicks(most, false);
  }

  linearTicks(most, whole) {
    const raw = (this.high - this.low) / most;
    let exponent = Math.floor(Math.log10(raw));
    const leading = raw / 10 ** exponent;
    let count = [1, 2, 5].find((step) => leading <= step * (1 + 1e-9));
    if (!count) [count, exponent] = [1, exponent + 1];
    if (whole && exponent < 0) [count, exponent] = [1, 0];
    const step = decimal({ count, exponent });
    const major = [];
    for (let i = Math.ceil(this.low / step - 1e-9); i * step <= this.high * (1 + 1e-12) + 1e-9 * step; i++) {
      major.push({ count: i * count, exponent });
    }
    const largest = Math.max(...major.map((tick) => Math.abs(decimal(tick))), 0);
    const power = isPlain(largest) ? 0 : Math.floor(Math.log10(largest) + 1e-9);
    const label = (tick) => {
      const shown = (tick.count * 10 ** (tick.exponent - power)).toFixed(Math.max(power - tick.exponent, 0));
      if (tick.count === 0) return "0";
      return power === 0 ? minus(shown) : `${minus(shown)}·10${raised(power)}`;
    };
    return { major: major.map((tick) => ({ value: decimal(tick), label: label(tick) })), minor: [] };
  }

  holds(value) {
    const at = this.fraction(value);
    return at >= -1e-9 && at <= 1 + 1e-9;
  }
}

function decimal({ count, exponent }) {
  return Number(`${count}e${exponent}`);
}

/** Whether labels of this size are easier to read in full than as powers of ten. */
function isPlain(size) {
  return size === 0 || (size >= 1e-3 * (1 - 1e-9) && size <= 1e5 * (1 + 1e-9));
}

/** Labels all alike: in full where that suits each of them, as powers of ten otherwise. */
function logLabels(labelled, all) {
  const inFull = labelled.every((tick) => isPlain(decimal(tick)));
  const label = ({ count, exponent }) => {
    if (inFull) return decimal({ count, exponent }).toFixed(Math.max(-exponent, 0));
    if (exponent === 0 || exponent === 1) return `${count}${"0".repeat(exponent)}`;
    return count === 1 ? `10${raised(exponent)}` : `${count}·10${raised(exponent)}`;
  };
  const major = labelled.map((tick) => ({ value: decimal(tick), label: label(tick) }));
  const minor = all.map(decimal).filter((value) => !major.some((tick) => tick.value === value));
  return { major, minor };
}
