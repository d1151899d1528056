// Numbers as people read them.

/** A number with so many significant digits, without trailing zeros. */
function significant(x, digits = 5) {
  if (x === 0) return "0";
  const [mantissa, exponent] = x.toExponential(digits - 1).split("e").map(Number);
  if (exponent >= -5 && exponent < Math.max(digits, 6)) {
    const text = Number(x.toPrecision(digits)).toFixed(Math.max(digits - 1 - exponent, 0));
    return minus(text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  }
  return `${minus(String(mantissa))}·10${raised(exponent)}`;
}

/** With a minus sign as wide as a figure. */
function minus(text) {
  return text.replace("-", "−");
}

/** An exponent in raised figures. */
function raised(exponent) {
  return String(exponent).replace(/[-0-9]/g, (figure) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(figure)]);
}

/** Digits of values that are read off. */
const READ = 4;

/** A value with its unit; signs of an angle stand beside the number. */
function measured(x, unit, digits = READ) {
  return `${significant(x, digits)}${!unit || "″°".includes(unit) ? "" : " "}${unit}`;
}

/** The title of an axis. */
function axisTitle(axis) {
  const title = axis.unit && !axis.times ? `${axis.label}, ${axis.unit}` : axis.label;
  return axis.defined ? `${title} with ${axis.defined}` : title;
}

/** What stands at a place of an axis, as a sentence has it. */
function axisValue(axis, x) {
  if (axis.names?.length > 0) return axis.names[x - 1] ?? "";
  return axis.unit ? `${axis.label} ${measured(x, axis.unit, 5)}` : `${axis.label} = ${significant(x)}`;
}
