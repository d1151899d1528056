// The modules of the site in Node, for builds and tests.

import { readFileSync } from "node:fs";

/** An instance of the module in a file, which answers messages as in a worker of the page. */
export function instance(file) {
  const module = new WebAssembly.Module(readFileSync(file));
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    imports[from] ??= {};
    imports[from][name] = () => {
      if (from !== "sagnac") throw new Error(`${from}.${name} was called`);
    };
  }
  const { memory, reserve, release, call } = new WebAssembly.Instance(module, imports).exports;
  const ask = (request, blobs = []) => {
    const json = Buffer.from(JSON.stringify({ ...request, blobs: blobs.map((blob) => blob.length) }));
    const length = Buffer.alloc(4);
    length.writeUInt32LE(json.length);
    const message = Buffer.concat([length, json, ...blobs]);
    const address = reserve(message.length) >>> 0;
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
  ask.bytes = () => memory.buffer.byteLength;
  return ask;
}
