// node web/test/bits.mjs SITE PROGRAM: the page gives the bits of the program in Chromium, whichever engine computes: one worker or
// several, with and without SIMD128, and WebGPU.

import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Browser, serve } from "./browser.mjs";
import { agrees, kernels, logs, studies } from "./digests.mjs";

const [folder, program] = process.argv.slice(2).map((path) => resolve(path));

/** Runs in the page: the digest of the points of a study, on so many workers or, with 0, on the GPU. */
async function pointsOf(study, trials, workers) {
  const { engine } = await import("/engine.js");
  if (workers > 0) engine.shares = workers;
  const { rows, by } = await engine.sample(study, { trials });
  const { reply } = await engine.ask({ call: "outcome", ...study, trials, complete: false }, { blobs: rows });
  return by.startsWith(workers > 0 ? `${workers} worker` : "WebGPU on") && !by.includes(";") ? reply.digest : by;
}

/** Runs in the page: the SHA-256 of the page and of the tables of a log, with intervals from records up to each of some numbers. */
async function filesOf(name, letters, options, records) {
  const { engine } = await import("/engine.js");
  const bytes = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
  const parts = [];
  for (const [at, to] of records.entries()) parts.push(...await engine.simulate({ name, options, from: records[at - 1] ?? 0, to }, { blobs: [bytes] }));
  const request = { call: "allan", name, options, simulated: records.at(-1) ?? 0, parts: parts.length };
  const { reply, blobs } = await engine.ask(request, { blobs: [bytes, ...parts.flat()] });
  const names = ["report.html", ...reply.files];
  const hash = async (blob) => Array.from(new Uint8Array(await crypto.subtle.digest("SHA-256", blob)), (byte) => byte.toString(16).padStart(2, "0")).join("");
  return Object.fromEntries(await Promise.all(blobs.map(async (blob, at) => [names[at], await hash(blob)])));
}

async function digestOfKernels() {
  const { engine } = await import("/engine.js");
  const { digest, rows } = (await engine.ask({ call: "verify", units: 4096 })).reply;
  const other = rows.filter(({ identical }) => !identical).map(({ kernel }) => kernel);
  return other.length === 0 ? `${digest} by ${(await engine.about).lanes}` : `another width differs in ${other.join(", ")}`;
}

/** Runs in the page: the digest of the kernels, where the GPU has their bits. */
async function digestOnGpu(units) {
  const { engine } = await import("/engine.js");
  const { digest, rows } = await engine.verifyOnGpu(units, {});
  const other = rows.filter(({ identical }) => !identical).map(({ kernel }) => kernel);
  return other.length === 0 ? digest : `the GPU differs in ${other.join(", ")}`;
}

/** Trials of a study on a GPU in software. */
const FEW = 4;

let failed = 0;
const expect = (name, found, expected) => {
  if (!agrees(name, found, expected)) failed += 1;
};
const site = await serve(folder);
const gallery = JSON.parse(readFileSync(join(folder, "gallery.json")));
const browser = await Browser.start(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]);
try {
  for (const [engine, address, workers] of [["SIMD128, 3 workers", "/", 3], ["portable, 1 worker", "/?portable", 1]]) {
    const page = await browser.open(site.origin + address);
    expect(`${engine}: kernels`, await page.evaluate(digestOfKernels), `${kernels()} by ${engine.split(",")[0]}`);
    for (const { name, study: { trials, ...study }, expected } of studies(gallery)) {
      expect(`${engine}: ${name}`, await page.evaluate(pointsOf, study, trials, workers), expected);
    }
    for (const [records, intervals] of [[[], "closed form"], [[200, 1000], "simulated"]]) {
      for (const { name, bytes, options, expected } of logs(program, { simulated: records.length > 0 })) {
        const found = await page.evaluate(filesOf, name, bytes.toString("base64"), options, records);
        for (const [file, digest] of Object.entries(expected)) expect(`${engine}, ${intervals}: ${name}: ${file}`, found[file], digest);
      }
    }
    await page.close();
  }
  // A GPU in software is slow: it makes few trials, as many as workers make beside it.
  const [gpu, workers] = [await browser.open(`${site.origin}/?webgpu`), await browser.open(site.origin)];
  expect("WebGPU: kernels", await gpu.evaluate(digestOnGpu, 4096), kernels());
  for (const { name, study: { trials, ...study } } of studies(gallery)) {
    const few = Math.min(trials, FEW);
    expect(`WebGPU: ${name}`, await gpu.evaluate(pointsOf, study, few, 0), await workers.evaluate(pointsOf, study, few, 3));
  }
} finally {
  await browser.close();
  await site.close();
}
process.exitCode = failed > 0 ? 1 : 0;
