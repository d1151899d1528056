// Elements of the page and of its pictures.

/** An HTML element with attributes, or handlers where these are functions. */
function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** An element of an SVG picture. */
function shape(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") made.addEventListener(name, value);
    else if (value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/** A button; `pressed` is given of one that switches. */
function button(label, title, act, pressed) {
  return element("button", { type: "button", title, click: act, "aria-pressed": pressed }, label);
}

/** The width of a text in px, as pictures have it. */
const textWidth = (() => {
  const context = document.createElement("canvas").getContext("2d");
  return (text, size) => {
    context.font = `${size}px system-ui, "DejaVu Sans", sans-serif`;
    return context.measureText(text).width;
  };
})();

/** Offers a text or a blob as a file. */
function save(name, type, content) {
  const link = element("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Rows of cells as CSV. */
function csvOf(rows) {
  const quoted = (cell) => (typeof cell === "string" && /[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell ?? "");
  return rows.map((row) => row.map(quoted).join(",")).join("\n") + "\n";
}

/** Copies a text, and says so on the button for a while. */
async function copy(text, made) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Where a browser keeps its clipboard from files.
    const area = element("textarea", {}, text);
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  const label = made.textContent;
  made.textContent = "Copied";
  setTimeout(() => {
    made.textContent = label;
  }, 1500);
}

/** A picture as SVG of its own: what the style sheet of the page says is written into its elements. */
function standalone(picture) {
  const looks = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "stroke-linecap",
    "paint-order", "font", "text-anchor", "opacity", "display"];
  const copied = picture.cloneNode(true);
  const copies = copied.querySelectorAll("*");
  picture.querySelectorAll("*").forEach((original, at) => {
    const style = getComputedStyle(original);
    copies[at].setAttribute("style", looks.map((look) => `${look}:${style.getPropertyValue(look)}`).join(";"));
  });
  copied.querySelectorAll(".mark, .box").forEach((reading) => reading.remove());
  const { width, height } = picture.viewBox.baseVal;
  for (const [name, value] of Object.entries({ width, height })) copied.setAttribute(name, value);
  const paper = getComputedStyle(document.body).backgroundColor;
  copied.prepend(shape("rect", { width: "100%", height: "100%", style: `fill:${paper}` }));
  return new XMLSerializer().serializeToString(copied);
}

/** Saves a picture as PNG with two pixels for each of the page. */
function savePng(name, picture) {
  const image = new Image();
  image.addEventListener("load", () => {
    const canvas = element("canvas", { width: 2 * image.width, height: 2 * image.height });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => save(name, "image/png", blob), "image/png");
  });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(standalone(picture))}`;
}
