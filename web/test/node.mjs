// node web/test/node.mjs SITE PROGRAM: holds both modules of the site against the program and the golden tables, in Node.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { instance } from "../instance.mjs";
import { agrees, kernels, logs, sha256, studies } from "./digests.mjs";

const [site, program] = process.argv.slice(2);

let failed = 0;
const expect = (name, found, expected) => {
  if (!agrees(name, found, expected)) failed += 1;
};
const gallery = JSON.parse(readFileSync(join(site, "gallery.json")));
const [ofStudies, ofLogs] = [studies(gallery), logs(program)];
for (const file of ["sagnac.wasm", "sagnac_simd.wasm"]) {
  const ask = instance(join(site, file));
  const { lanes } = ask({ call: "about" });
  expect(`${lanes}: kernels`, ask({ call: "verify", units: 4096 }).digest, kernels());
  for (const { name, study, expected } of ofStudies) {
    const shares = [1, 2].map((number) => ask({ call: "share", ...study, number, of: 2 }).blobs[0]);
    expect(`${lanes}: ${name}`, ask({ call: "outcome", ...study, complete: false }, shares).digest, expected);
  }
  for (const { name, bytes, options, expected } of ofLogs) {
    const { files, blobs } = ask({ call: "allan", name, options }, [bytes]);
    const found = { "report.html": blobs[0], ...Object.fromEntries(files.map((file, at) => [file.name, blobs[at + 1]])) };
    for (const [table, digest] of Object.entries(expected)) expect(`${lanes}: ${name}: ${table}`, sha256(found[table]), digest);
  }
}
process.exit(failed > 0 ? 1 : 0);
