// One instance of the program. It answers one request after the other and shares nothing with other instances.

let program;
let progress = () => {};

/** Least time in ms between two reports of progress. */
const PAUSE = 50;

/** The last words of the program before it stopped. */
let trouble = "";

const OURS = {
  progress: (done, all) => progress(Number(done), Number(all)),
  trouble: (address, length) => { trouble = new TextDecoder().decode(new Uint8Array(program.memory.buffer, address >>> 0, length)); },
};

/** The page compiles the module once, and each worker makes an instance of it. */
async function instantiate(module) {
  const imports = {};
  for (const { module: from, name, kind } of WebAssembly.Module.imports(module)) {
    if (kind !== "function") throw new Error(`the module wants a ${kind}, ${from}.${name}`);
    imports[from] ??= {};
    imports[from][name] = from === "sagnac" ? OURS[name] : () => { throw new Error(`${from}.${name} is not there in a browser`); };
  }
  return (await WebAssembly.instantiate(module, imports)).exports;
}

/** The length of the JSON, the JSON with the lengths of the blobs, the blobs. */
function write(request, blobs) {
  const json = new TextEncoder().encode(JSON.stringify({ ...request, blobs: blobs.map((blob) => blob.length) }));
  const length = 4 + json.length + blobs.reduce((sum, blob) => sum + blob.length, 0);
  const address = program.reserve(length) >>> 0;
  // The memory may have moved by the reservation.
  new DataView(program.memory.buffer).setUint32(address, json.length, true);
  const bytes = new Uint8Array(program.memory.buffer, address, length);
  let at = 4;
  for (const part of [json, ...blobs]) {
    bytes.set(part, at);
    at += part.length;
  }
  return { address, length };
}

function read(address, length) {
  const bytes = new Uint8Array(program.memory.buffer, address, length);
  let at = 4 + new DataView(program.memory.buffer).getUint32(address, true);
  const { blobs = [], ...reply } = JSON.parse(new TextDecoder().decode(bytes.subarray(4, at)));
  return { reply, blobs: blobs.map((size) => bytes.slice(at, (at += size))) };
}

function call(request, blobs) {
  const asked = write(request, blobs);
  const place = BigInt.asUintN(64, program.call(asked.address, asked.length));
  const [address, length] = [Number(place >> 32n), Number(place & 0xffffffffn)];
  const answer = read(address, length);
  program.release(address, length);
  program.release(asked.address, asked.length);
  return answer;
}

onmessage = async ({ data: { module, request, blobs } }) => {
  try {
    if (module) {
      program = instantiate(module);
      return;
    }
    program = await program;
    let last = 0;
    progress = (done, all) => {
      const now = performance.now();
      if (now - last < PAUSE) return;
      last = now;
      postMessage({ progress: [done, all] });
    };
    const answer = call(request, blobs);
    postMessage(answer, answer.blobs.map((blob) => blob.buffer));
  } catch (error) {
    // After a trap the instance is unusable: the page ends this worker.
    postMessage({ reply: { error: { kind: "stopped", text: `The program stopped: ${trouble || error.message}` } }, blobs: [] });
  }
};
