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

/** Offers a text as a file. */
function save(name, type, text) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** A picture as a file of its own: what the style sheet of the page says is written into its elements. */
function savePicture(name, picture) {
  const looks = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "stroke-linecap",
    "paint-order", "font", "text-anchor", "opacity", "display"];
  const copy = picture.cloneNode(true);
  const copies = copy.querySelectorAll("*");
  picture.querySelectorAll("*").forEach((original, at) => {
    const style = getComputedStyle(original);
    copies[at].setAttribute("style", looks.map((look) => `${look}:${style.getPropertyValue(look)}`).join(";"));
  });
  copy.querySelectorAll(".mark, .box").forEach((reading) => reading.remove());
  const paper = getComputedStyle(document.body).backgroundColor;
  copy.prepend(shape("rect", { width: "100%", height: "100%", style: `fill:${paper}` }));
  save(name, "image/svg+xml", new XMLSerializer().serializeToString(copy));
}
