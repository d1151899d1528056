// Holds WebAssembly against the digests of the tests on processors: node check.mjs MODULE.wasm
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

const root = new URL("../../", import.meta.url);
const read = (path) => readFileSync(new URL(path, root), "utf8");
const module = new WebAssembly.Module(readFileSync(process.argv[2]));
// A dependency can take random numbers from a browser, which nothing here does.
const imports = {};
for (const { module: from, name } of WebAssembly.Module.imports(module)) {
  imports[from] ??= {};
  imports[from][name] = () => {
    throw new Error(`${name} was called`);
  };
}
const instance = new WebAssembly.Instance(module, imports);
const { memory, reserve, digest, points } = instance.exports;

let failed = false;
function check(name, found, expected) {
  console.log(`${found === expected ? "ok  " : "FAIL"} ${name}`);
  if (found !== expected) {
    console.error(`${name}: ${found}, expected ${expected}`);
    failed = true;
  }
}

const [, kernels] = read("docs/dev/verified-devices.md").match(/`([0-9a-f]{16})` with `--trials 4096`/);
check("kernels", BigInt.asUintN(64, digest(4096)).toString(16).padStart(16, "0"), kernels);

// With the trials of the golden tables: 512, or fewer where the study has fewer than 256.
const studies = [
  ["smoke", 512],
  ["design_point", 512],
  ["noise_error_vs_gap", 512],
  ["optimal_interval", 512],
  ["quantizer", 512],
  ["lock_in_static", 16],
  ["relock_tables", 512],
];
const goldens = read("tests/data/tables.sha256");
for (const [name, trials] of studies) {
  const text = new TextEncoder().encode(read(`studies/${name}.toml`));
  const address = reserve(text.length);
  new Uint8Array(memory.buffer, address, text.length).set(text);
  const place = BigInt.asUintN(64, points(address, text.length, trials));
  const csv = new Uint8Array(memory.buffer, Number(place >> 32n), Number(place & 0xffffffffn));
  const [, golden] = goldens.match(new RegExp(`([0-9a-f]{64})  ${name}/points.csv`));
  const found = createHash("sha256").update(csv).digest("hex");
  if (found !== golden && !csv.includes(10)) console.error(new TextDecoder().decode(csv));
  check(`${name}/points.csv`, found, golden);
}
process.exit(failed ? 1 : 0);
