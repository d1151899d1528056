// The converter of noise units.

import { button, byId, element, showError, table } from "./elements.js";
import { engine } from "./engine.js";

const EXAMPLES = ["0.0135 deg/s/sqrt(Hz)", "0.003 deg/sqrt(h)", "4 mdps/rtHz", "8.7e-5 rad/s/sqrt(Hz)", "0.5 deg/h/sqrt(h)", "2 deg/h"];

export class ConvertView {
  constructor() {
    this.input = byId("convert-text");
    byId("convert-examples").append(...EXAMPLES.map((text) => button(text, `Convert ${text}`, () => {
      this.input.value = text;
      this.#convert();
    })));
    byId("convert-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#convert();
    });
    this.input.addEventListener("input", () => this.#convert());
  }

  enter() {
    this.#convert();
  }

  async #convert() {
    const text = this.input.value;
    try {
      const { reply } = await engine.ask({ call: "convert", text });
      if (text !== this.input.value) return;
      showError(byId("convert-error"), null);
      const rows = reply.rows.map(({ convention, value, unit }) => [convention, element("span", { title: value }, written(value)), unit]);
      byId("convert-result").replaceChildren(element("p", { class: "headline", role: "status" }, reply.quantity),
        table(`${text} in other units`, [{ label: "Convention", isText: true }, { label: "Value" }, { label: "Unit", isText: true }], rows));
    } catch (error) {
      if (text !== this.input.value) return;
      byId("convert-result").replaceChildren();
      showError(byId("convert-error"), error);
    }
  }
}

/** Five digits of a number. */
function written(number) {
  const size = Math.abs(number);
  return size === 0 || (size >= 1e-3 && size < 1e6) ? Number(number.toPrecision(5)).toString() : number.toExponential(4);
}
