// The digests of the kernels in this browser.

import { Progress, announce, button, byId, copy, element, seconds, showError, table } from "./elements.js";
import { engine, isStopped } from "./engine.js";

/** The digest of the program by the units of work, where it is known. */
const known = fetch("verified.json").then((response) => response.json(), () => ({}));

export class VerifyView {
  constructor(about) {
    this.about = about;
    this.progress = new Progress(byId("verify-progress"));
    byId("verify-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#verify(byId("verify-units").valueAsNumber);
    });
  }

  async #verify(units) {
    const signal = this.progress.begin("Running all kernels");
    showError(byId("verify-error"), null);
    byId("verify-result").replaceChildren();
    try {
      const begun = performance.now();
      const [about, { reply }] = await Promise.all([this.about, engine.ask({ call: "verify", units }, { signal, progress: (...part) => this.progress.set(...part) })]);
      await this.#show(reply, units, about, performance.now() - begun);
    } catch (error) {
      if (!isStopped(error)) showError(byId("verify-error"), error);
    } finally {
      this.progress.end(signal);
    }
  }

  async #show({ digest, rows }, units, { lanes, version }, took) {
    const { name, system } = browser();
    const different = rows.filter(({ identical }) => !identical);
    const expected = (await known)[units];
    const isOther = expected !== undefined && expected !== digest;
    const verdict = different.length > 0 ? `Different: ${different.map(({ kernel }) => kernel).join(", ")}.`
      : isOther ? "Different: the digest is not that of the program."
        : expected === undefined ? `All ${rows.length} kernels agree in every width of this browser. The program prints its digest with: sagnac device verify --trials ${units}`
          : `Identical: all ${rows.length} kernels have the digest of the program.`;
    const result = different.length === 0 && !isOther ? "identical" : "DIFFERENT";
    const line = `| ${[name, "–", "WebAssembly", lanes, system, version, units, digest, result, new Date().toISOString().slice(0, 10)].join(" | ")} |`;
    byId("verify-result").replaceChildren(
      element("p", { class: "headline" }, verdict),
      element("p", { class: "hint" }, `${lanes}, ${seconds(took)}. Digest of all: `, element("code", {}, digest)),
      table("Kernels", [{ label: "Kernel", isText: true }, { label: "Digest", isText: true }, { label: "Widths", isText: true }],
        rows.map(({ kernel, digest: each, identical }) => [kernel, element("code", {}, each), identical ? "identical" : "different"])),
      element("p", {}, "The row of this browser for the list of verified devices:"),
      element("pre", { tabindex: "0", "aria-label": "Row of this browser" }, line),
      button("Copy row", "Copy the row as Markdown", ({ currentTarget }) => copy(line, currentTarget)));
    announce(verdict);
  }
}

/** Name, version and system of the browser, as far as it tells them. */
function browser() {
  const agent = navigator.userAgent;
  const [, name, version] = /(Firefox|Edg|Chrome)\/(\d+)/.exec(agent) ?? /(Version)\/(\d+)/.exec(agent) ?? [null, "Browser", ""];
  const names = { Edg: "Edge", Version: "Safari" };
  const system = /Windows|Android|Linux|Mac OS X|iPhone|iPad/.exec(agent)?.[0] ?? "";
  return { name: `${names[name] ?? name} ${version}`.trim(), system };
}
