// node web/test/node.mjs SITE PROGRAM: holds both modules of the site against the program and the golden tables, in Node.

import { readFileSync, readdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { instance } from "../instance.mjs";
import { agrees, kernels, logs, pageOf, sha256, studies, withoutMachine } from "./digests.mjs";

const [site, program] = process.argv.slice(2).map((path) => resolve(path));

let failed = 0;
const expect = (name, found, expected) => {
  if (!agrees(name, found, expected)) failed += 1;
};
const gallery = JSON.parse(readFileSync(join(site, "gallery.json")));
const [ofStudies, ofLogs] = [studies(gallery), logs(program)];
const pages = ofStudies.map(({ study }) => withoutMachine(pageOf(program, study)));
for (const [file, lanes] of [["sagnac.wasm", "portable"], ["sagnac_simd.wasm", "SIMD128"]]) {
  const ask = instance(join(site, file));
  expect(`${lanes}: width`, ask({ call: "about" }).lanes, lanes);
  const { digest, rows } = ask({ call: "verify", units: 4096 });
  expect(`${lanes}: kernels`, digest, kernels());
  expect(`${lanes}: widths that differ`, rows.filter(({ identical }) => !identical).length, 0);
  for (const [at, { name, study, expected }] of ofStudies.entries()) {
    const shares = [1, 2].map((number) => ask({ call: "share", ...study, number, of: 2 }).blobs[0]);
    const { digest, blobs } = ask({ call: "outcome", ...study, complete: true }, shares);
    expect(`${lanes}: ${name}`, digest, expected);
    expect(`${lanes}: ${name}: report.html`, sha256(withoutMachine(Buffer.from(blobs[0]))), sha256(pages[at]));
  }
  for (const { name, bytes, options, expected } of ofLogs) {
    const { files, blobs } = ask({ call: "allan", name, options, simulated: 0 }, [bytes]);
    const found = { "report.html": blobs[0], ...Object.fromEntries(files.map((name, at) => [name, blobs[at + 1]])) };
    for (const [table, digest] of Object.entries(expected)) expect(`${lanes}: ${name}: ${table}`, sha256(found[table]), digest);
  }
}
// Damaged files and files that unpack to gigabytes are refused or read, and end no worker.
const ask = instance(join(site, "sagnac_simd.wasm"));
const bombs = readdirSync(new URL("../../tests/data/bombs", import.meta.url)).map((name) => ({ name, bytes: readFileSync(new URL(`../../tests/data/bombs/${name}`, import.meta.url)), isBomb: true }));
const allowed = 1.5 * 2 ** 30;
let refused = 0;
for (const { name, bytes, isBomb } of [...ofLogs.filter(({ bytes }) => bytes.length < 1e5).flatMap(damaged), ...bombs]) {
  try {
    ask({ call: "allan", name, options: { data: "rate", unit: "rad/s", column: "2", rate: "200 Hz" }, simulated: 0 }, [bytes]);
  } catch (error) {
    if (error.constructor !== Error) {
      console.log(`FAIL ${name}: ${error.message}`);
      failed += 1;
      break;
    }
    refused += 1;
    continue;
  }
  if (isBomb) expect(`${name} is refused`, false, true);
}
expect("more than half of the damaged and all hostile files are refused", refused > 250, true);
expect("memory after all of them is bounded", ask.bytes() < allowed, true);
process.exit(failed > 0 ? 1 : 0);

/** A file with bytes changed or cut off at a hundred places. */
function damaged({ name, bytes }) {
  return Array.from({ length: 100 }, (_, at) => {
    const place = Math.floor((at * bytes.length) / 100);
    if (at % 4 === 3) return { name, bytes: bytes.subarray(0, place) };
    const copy = Buffer.from(bytes);
    copy[place] ^= 1 << at % 8;
    return { name, bytes: copy };
  });
}
