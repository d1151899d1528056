// node web/test/node.mjs SITE PROGRAM: holds both modules of the site against the program and the golden tables, in Node.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { agrees, kernels, logs, sha256, studies } from "./digests.mjs";

const [site, program] = process.argv.slice(2);

/** An instance of a module, which answers messages as in a worker of the page. */
function instance(file) {
  const module = new WebAssembly.Module(readFileSync(join(site, file)));
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = () => {
      if (from !== "sagnac") throw new Error(`${from}.${name} was called`);
    };
  }
  const { memory, reserve, release, call } = new WebAssembly.Instance(module, imports).exports;
  return (request, blobs = []) => {
    const json = Buffer.from(JSON.stringify({ ...request, blobs: blobs.map((blob) => blob.length) }));
    const length = Buffer.alloc(4);
    length.writeUInt32LE(json.length);
    const message = Buffer.concat([length, json, ...blobs]);
    const address = reserve(message.length);
    new Uint8Array(memory.buffer, address, message.length).set(message);
    const place = BigInt.asUintN(64, call(address, message.length));
    release(address, message.length);
    const [at, size] = [Number(place >> 32n), Number(place & 0xffffffffn)];
    const answer = Buffer.from(new Uint8Array(memory.buffer, at, size));
    release(at, size);
    let from = 4 + answer.readUInt32LE(0);
    const reply = JSON.parse(answer.subarray(4, from));
    if (reply.error) throw new Error(reply.error.text);
    return { ...reply, blobs: reply.blobs.map((size) => answer.subarray(from, (from += size))) };
  };
}

let failed = 0;
const expect = (name, found, expected) => {
  if (!agrees(name, found, expected)) failed += 1;
};
const gallery = JSON.parse(readFileSync(join(site, "gallery.json")));
const [ofStudies, ofLogs] = [studies(gallery), logs(program)];
for (const file of ["sagnac.wasm", "sagnac_simd.wasm"]) {
  const ask = instance(file);
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
