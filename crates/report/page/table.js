// Tables: sorted by any column, narrowed to chosen values, and saved as CSV.

const PAGE = 25;

/** A cell in the unit in which people read it, which may be another one than that of the file. */
function inUnit(column, cell) {
  return typeof cell === "number" && column.factor !== 1 ? Number((cell * column.factor).toPrecision(12)) : cell;
}

class Listing {
  constructor(host, table) {
    this.table = table;
    this.count = table.shown;
    // Columns of one value hold it once.
    this.cell = (column, row) => (column.cells.length === 1 ? column.cells[0] : column.cells[row]);
    this.sorted = { column: null, falling: false };
    this.chosen = new Map();
    this.page = PAGE;
    this.head = element("tr");
    this.body = element("tbody");
    this.said = element("p", { class: "hint said", role: "status" });
    // Instead of the first rows, which are there without a script.
    host.replaceChildren(this.filters(), this.said, element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": table.file },
      element("table", {}, element("thead", {}, this.head), this.body)));
    this.more = element("div", { class: "tools" },
      button("More rows", "Show more rows", () => this.list(this.page * 4)), button("All rows", "Show all rows", () => this.list(Infinity)));
    host.append(this.more);
    this.list(PAGE);
  }

  /** A choice for each column that has a few values, and what becomes of them. */
  filters() {
    const bar = element("div", { class: "tools" });
    for (const column of this.table.columns) {
      const values = [...new Set(column.cells)].filter((value) => value !== null);
      if (values.length < 2 || values.length > 40 || !column.tells) continue;
      const options = values.map((value, at) => element("option", { value: at }, typeof value === "number" ? significant(inUnit(column, value)) : value));
      const select = element("select", {
        change: (event) => {
          const at = event.currentTarget.value;
          if (at === "") this.chosen.delete(column);
          else this.chosen.set(column, values[at]);
          this.list(PAGE);
        },
      }, element("option", { value: "" }, "all"), ...options);
      bar.append(element("label", {}, `${column.title} `, select));
    }
    bar.append(button("Save CSV", "Save the rows that are chosen, in this order", () => this.save()));
    return bar;
  }

  rows() {
    const rows = [];
    for (let row = 0; row < this.count; row++) {
      if ([...this.chosen].every(([column, value]) => this.cell(column, row) === value)) rows.push(row);
    }
    const { column, falling } = this.sorted;
    if (!column) return rows;
    // Blanks last, however it is sorted.
    const order = (a, b) => {
      const [x, y] = [this.cell(column, a), this.cell(column, b)];
      if (x === null || y === null) return (x === null) - (y === null);
      const sign = typeof x === "number" ? x - y : x.localeCompare(y);
      return falling ? -sign : sign;
    };
    return rows.sort(order);
  }

  list(page) {
    this.page = page;
    const rows = this.rows();
    const shown = rows.slice(0, page);
    this.head.replaceChildren(...this.table.columns.map((column) => this.heading(column)));
    this.body.replaceChildren(...shown.map((row) => element("tr", {}, ...this.table.columns.map((column) => {
      const cell = inUnit(column, this.cell(column, row));
      if (typeof cell !== "number") return element("td", { class: "text" }, cell ?? "");
      const exact = Number.isInteger(cell) && Math.abs(cell) < 1e15;
      return element("td", { title: String(cell) }, exact ? minus(String(cell)) : significant(cell, READ));
    }))));
    this.said.textContent = rows.length > shown.length ? `${shown.length} of ${rows.length} rows` : `${rows.length} ${rows.length === 1 ? "row" : "rows"}`;
    this.more.hidden = rows.length <= shown.length;
  }

  heading(column) {
    const { sorted } = this;
    const here = sorted.column === column;
    const sign = here ? (sorted.falling ? " ▼" : " ▲") : "";
    const act = () => {
      this.sorted = here && sorted.falling ? { column: null, falling: false } : { column, falling: here };
      this.list(this.page);
      [...this.head.querySelectorAll("button")].find((each) => each.dataset.header === column.header)?.focus();
    };
    const made = button(`${column.title}${sign}`, column.about ? `${column.header}: ${column.about}` : column.header, act);
    made.dataset.header = column.header;
    const order = here ? (sorted.falling ? "descending" : "ascending") : "none";
    return element("th", { scope: "col", class: column.text ? "text" : null, "aria-sort": order }, made);
  }

  save() {
    const { columns, file } = this.table;
    const rows = this.rows().map((row) => columns.map((column) => this.cell(column, row)));
    save(file.replace(".csv", "-chosen.csv"), "text/csv", csvOf([columns.map((column) => column.header), ...rows]));
  }
}
