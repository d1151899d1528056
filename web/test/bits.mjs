// node web/test/bits.mjs SITE PROGRAM [--gpu]: the page gives the bits of the program in Chromium, whichever engine computes: one worker or
// several, with and without SIMD128, and WebGPU; with --gpu, all kernels on WebGPU too.

import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Browser, serve } from "./browser.mjs";
import { agrees, digestOfKernels, kernels, logs, pointsOf, studies } from "./digests.mjs";

const [folder, program] = process.argv.slice(2).map((path) => resolve(path));
const isWhole = process.argv[4] === "--gpu";

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
  // It compiles 67 shaders, which takes minutes in software.
  if (isWhole) expect("WebGPU: kernels", await gpu.evaluate(digestOnGpu, 4096), kernels());
  for (const { name, study: { trials, ...study } } of studies(gallery)) {
    const few = Math.min(trials, FEW);
    expect(`WebGPU: ${name}`, await gpu.evaluate(pointsOf, study, few, 0), await workers.evaluate(pointsOf, study, few, 3));
  }
} finally {
  await browser.close();
  await site.close();
}
process.exitCode = failed > 0 ? 1 : 0;
