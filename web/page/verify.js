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
      const progress = (...part) => this.progress.set(...part);
      const [about, { reply }] = await Promise.all([this.about, engine.ask({ call: "verify", units }, { signal, progress })]);
      const took = performance.now() - begun;
      await this.#show(reply, units, about, took, null);
      // What the GPU does not do is no fault of the processor.
      const gpu = await engine.verifyOnGpu(units, { signal, progress }).catch((error) => {
        if (isStopped(error)) throw error;
        return { failure: error.message };
      });
      if (gpu) await this.#show(reply, units, about, took, gpu);
    } catch (error) {
      if (!isStopped(error)) showError(byId("verify-error"), error);
    } finally {
      this.progress.end(signal);
    }
  }

  /** Shows the digests of the processor, and those of a GPU that has answered: its name with rows, or why it failed. */
  async #show({ digest, rows }, units, { lanes, version }, took, gpu) {
    const { name, system } = browser();
    const different = rows.concat(gpu?.rows ?? []).filter(({ identical }) => !identical);
    const expected = (await known)[units];
    const isOther = expected !== undefined && expected !== digest;
    const where = gpu?.rows ? ` on the processor and on ${gpu.name}` : "";
    const verdict = different.length > 0 ? `Different: ${[...new Set(different.map(({ kernel }) => kernel))].join(", ")}.`
      : isOther ? "Different: the digest is not that of the program."
        : expected === undefined ? `All ${rows.length} kernels agree in every width of this browser${where}. The program prints its digest with: sagnac device verify --trials ${units}`
          : `Identical: all ${rows.length} kernels have the digest of the program${where}.`;
    const line = (device, backend, variant, found) => {
      const result = isOther || found.some(({ identical }) => !identical) ? "DIFFERENT" : "identical";
      return `| ${[device, "–", backend, variant, system, version, units, digest, result, new Date().toISOString().slice(0, 10)].join(" | ")} |`;
    };
    const lines = [line(name, "WebAssembly", lanes, rows), ...(gpu?.rows ? [line(gpu.name, `WebGPU in ${name}`, "16-bit products, workgroup 64", gpu.rows)] : [])];
    const word = ({ identical }) => (identical ? "identical" : "different");
    const columns = ["Kernel", "Digest", "Widths", ...(gpu?.rows ? ["WebGPU"] : [])].map((label) => ({ label, isText: true }));
    byId("verify-result").replaceChildren(
      element("p", { class: "headline" }, verdict),
      element("p", { class: "hint" }, `${lanes}, ${seconds(took)}. Digest of all: `, element("code", {}, digest)),
      ...(gpu?.failure ? [element("p", { class: "note" }, `Not compared on WebGPU: ${gpu.failure.split("\n")[0]}`)] : []),
      table("Kernels", columns, rows.map((row, at) => [row.kernel, element("code", {}, row.digest), word(row), ...(gpu?.rows ? [word(gpu.rows[at])] : [])])),
      element("p", {}, "For the list of verified devices:"),
      element("pre", { tabindex: "0", "aria-label": "Rows of this browser" }, lines.join("\n")),
      button("Copy rows", "Copy the rows as Markdown", ({ currentTarget }) => copy(lines.join("\n"), currentTarget)));
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
