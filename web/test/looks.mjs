// States of the page that tests look at, and what is hard to read or to use in them.

import { deflateRawSync } from "node:zlib";

/** The address of a study that is not shipped. */
export const linkOf = (text) => `#s=${deflateRawSync(text).toString("base64url")}`;
export const isShown = (view) => `!document.getElementById("view-${view}").hidden`;
export const hasReport = (view) => `document.querySelector("#${view}-report iframe:not(.incoming)")`;
export const isIdle = (view) => `document.getElementById("${view}-progress").dataset.state === "idle"`;

/** Goes to a view or a study. */
export async function goTo(page, hash) {
  await page.evaluate((fragment) => { location.hash = fragment; }, hash);
}

async function complete(page, view) {
  await page.until(hasReport(view), `the report of ${view}`);
  // Another run may follow at once.
  await page.until(`new Promise((resolve) => setTimeout(() => resolve(${isIdle(view)}), 700))`, `the end of ${view}`, 60000);
  await page.evaluate(`document.querySelectorAll("#view-${view} details").forEach((each) => { each.open = true; })`);
}

/** A log that does not tell its rate. */
export const bare = { name: "bare.csv", bytes: Buffer.from(`rate [deg/h]\n${Array.from({ length: 3000 }, (_, at) => Math.sin(at * at).toFixed(4)).join("\n")}\n`) };
const noise = (step) => Buffer.from(`time [s],rate [deg/h]\n${Array.from({ length: 4000 }, (_, at) => `${at / 100},${Math.sin(at * at * step).toFixed(4)}`).join("\n")}\n`);

/** Brings a page into each state. */
export const STATES = {
  start: async () => {},
  studies: async (page) => {
    await goTo(page, "#studies");
    await page.until(`document.querySelector("#gallery a")`, "the gallery");
  },
  study: async (page) => {
    await goTo(page, "#study=gyrocompass");
    await complete(page, "study");
  },
  "study with long columns": async (page) => {
    await goTo(page, "#study=quantizer");
    await complete(page, "study");
  },
  "study with a mistake": async (page) => {
    await page.evaluate(() => {
      const text = document.getElementById("study-text");
      text.value = text.value.replace("kind", "kinds");
      text.dispatchEvent(new Event("input"));
    });
    await page.until(`!document.getElementById("study-error").hidden`, "the message");
  },
  convert: async (page) => {
    await goTo(page, "#convert");
    await page.until(`document.querySelector("#convert-result table")`, "the table of units");
  },
  verify: async (page) => {
    await goTo(page, "#verify");
    await page.evaluate(`document.querySelector("#verify-form button").click()`);
    await page.until(`document.querySelector("#verify-result table")`, "the table of kernels", 60000);
  },
  log: async (page) => {
    await goTo(page, "#log");
    await page.evaluate(`document.getElementById("example").click()`);
    await complete(page, "log");
  },
  comparison: async (page) => {
    await page.drop([{ name: "one.csv", bytes: noise(1.3) }, { name: "two.csv", bytes: noise(2.7) }]);
    await page.until(`${hasReport("log")}?.title.includes("two")`, "the comparison");
    await complete(page, "log");
  },
  "log with a message": async (page) => {
    await page.drop([bare]);
    await page.until(`!document.getElementById("log-error").hidden`, "the message");
  },
};

/**
 * Runs in the page, and looks into the reports that it shows. `contrast` is the least one of a text with what is behind it,
 * `faint` are the texts below the contrast of WCAG 2.2 AA, `barriers` are what screen readers and fingers stumble over, and `broken` are
 * words and numbers of tables that go over two lines, tables of answers that scroll downwards, and pages that scroll sideways.
 */
export function survey() {
  const pages = [document, ...[...document.querySelectorAll("iframe:not(.incoming)")].filter((frame) => frame.checkVisibility()).map((frame) => frame.contentDocument)];
  const found = { contrast: Infinity, faint: [], barriers: [], broken: [] };
  const short = (text) => text.trim().replace(/\s+/g, " ").slice(0, 40);

  /** Red, green, blue and alpha, each up to 1. */
  const colour = (text) => {
    const [red, green, blue, alpha = 1] = text.match(/-?[\d.]+(e-?\d+)?/g).map(Number);
    return [...[red, green, blue].map((part) => (text.startsWith("color(srgb") ? part : part / 255)), alpha];
  };
  const over = ([...above], below) => {
    const alpha = above[3] + below[3] * (1 - above[3]);
    return alpha === 0 ? above : [0, 1, 2].map((at) => (above[at] * above[3] + below[at] * below[3] * (1 - above[3])) / alpha).concat(alpha);
  };
  const luminance = (parts) => [0.2126, 0.7152, 0.0722].reduce((sum, weight, at) => sum + weight * (parts[at] <= 0.04045 ? parts[at] / 12.92 : ((parts[at] + 0.055) / 1.055) ** 2.4), 0);

  function contrast(element, text) {
    // The text with its backgrounds, and these alone, through the opacities of all that they are in.
    let [written, behind] = [colour(text), [0, 0, 0, 0]];
    for (let at = element; at; at = at.parentElement ?? at.ownerDocument.defaultView.frameElement) {
      const { backgroundColor, opacity } = getComputedStyle(at);
      [written, behind] = [written, behind].map((layer) => over(layer, colour(backgroundColor))).map(([red, green, blue, alpha]) => [red, green, blue, alpha * opacity]);
    }
    const [less, more] = [written, behind].map((layer) => luminance(over(layer, [1, 1, 1, 1]))).sort((a, b) => a - b);
    return (more + 0.05) / (less + 0.05);
  }

  function measure(element, text, pseudo = null) {
    const { color, fill, fontSize, fontWeight } = getComputedStyle(element, pseudo);
    const isLarge = parseFloat(fontSize) >= 24 || (parseFloat(fontSize) >= 18.66 && fontWeight >= 700);
    const ratio = contrast(element, element.ownerSVGElement ? fill : color);
    found.contrast = Math.min(found.contrast, ratio);
    if (ratio < (isLarge ? 3 : 4.5)) found.faint.push(`${short(text)} ${ratio.toFixed(2)}`);
  }

  /** How many lines a part of a text takes. */
  function lines(node, start, end) {
    const range = node.ownerDocument.createRange();
    range.setStart(node, start);
    range.setEnd(node, end);
    return new Set([...range.getClientRects()].filter(({ width }) => width > 0).map(({ top }) => Math.round(top))).size;
  }

  const nameOf = (element) => (element.getAttribute("aria-label") ?? element.getAttribute("aria-labelledby")?.split(" ").map((id) => element.ownerDocument.getElementById(id).textContent).join(" ")
    ?? ([...(element.labels ?? [])].map((label) => label.textContent).join(" ") || element.textContent || element.title || element.alt || "")).trim();

  for (const page of pages) {
    const seen = [...page.querySelectorAll("*")].filter((each) => each.checkVisibility({ visibilityProperty: true }));
    const which = (selector) => seen.filter((each) => each.matches(selector));
    for (const element of seen) {
      const isDisabled = element.closest(":disabled") !== null;
      if (element.matches("input:not([type=range]), select, textarea") && !isDisabled) {
        const isPlaceholder = element.placeholder && !element.value;
        measure(element, isPlaceholder ? element.placeholder : element.value, isPlaceholder ? "::placeholder" : null);
      }
      if (element.matches("script, style, option, textarea, title, noscript")) continue;
      for (const node of element.childNodes) {
        if (node.nodeType !== Node.TEXT_NODE || !node.data.trim() || isDisabled) continue;
        measure(element, node.data);
        if (!element.closest("td, th")) continue;
        // A number with its unit, or a word up to a hyphen between letters.
        for (const { index, 0: word } of node.data.matchAll(/\S*\d[ \u00a0\u202f](%|°\S*|″\S*|(ms|s|min|h|d|Hz|g|nmi)\b)|([^\s-]|-(?=\u2060?\d)|(?<=\s|^)-)+-?/g)) {
          if (lines(node, index, index + word.length) > 1) found.broken.push(word);
        }
      }
    }
    const root = page.documentElement;
    if (root.scrollWidth > root.clientWidth) found.broken.push(`${page.title} is ${root.scrollWidth} px wide`);
    for (const box of which("#answer .scroll")) if (box.scrollHeight > box.clientHeight + 1) found.broken.push(`a table of ${box.scrollHeight} px is ${box.clientHeight} px high`);

    const stumble = (what, elements) => found.barriers.push(...elements.map((each) => `${what}: ${each.localName}${each.id && `#${each.id}`} ${short(each.textContent)}`));
    if (!root.lang || !page.title) stumble("no language or title", [root]);
    stumble("no name", which("button, a[href], summary, input:not([type=hidden]), select, textarea, iframe, [role=region], svg[tabindex]").filter((each) => !nameOf(each)));
    stumble("no alt", which("img:not([alt])"));
    const ids = [...page.querySelectorAll("[id]")];
    stumble("id used twice", ids.filter(({ id }, at) => ids.findIndex((each) => each.id === id) !== at));
    // A report begins below the heading of the page around it.
    const headings = which("h1, h2, h3, h4, h5, h6");
    const level = (heading) => Number(heading?.localName[1] ?? (page === document ? 0 : 1));
    stumble("heading skips a level", headings.filter((each, at) => level(each) > level(headings[at - 1]) + 1));
    stumble("scrolls without the keyboard", seen.filter((each) => /auto|scroll/.test(getComputedStyle(each).overflowX) && each.scrollWidth > each.clientWidth + 1 && each.tabIndex < 0));
    // A link within a sentence is as high as its line.
    stumble("smaller than 24 px", which("button, a[href], summary, input, select, textarea").filter((each) => {
      const { width, height } = each.getBoundingClientRect();
      const isInSentence = getComputedStyle(each).display === "inline" && each.parentElement.textContent.trim() !== each.textContent.trim();
      return !isInSentence && !each.closest(".skip") && (width < 24 || height < 24);
    }));
  }
  return found;
}
