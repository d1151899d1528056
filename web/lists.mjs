// node web/lists.mjs SITE: adds to the site the style that it shares with reports, the gallery of studies, the example log, the digest of
// the one script that reports may run, and the list of its files.

import { createHash } from "node:crypto";
import { copyFileSync, existsSync, mkdirSync, readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import { instance } from "./instance.mjs";

const site = process.argv[2];
const root = fileURLToPath(new URL("..", import.meta.url));
const studies = join(root, "studies");

/** The value of a text at the top of a study. */
const value = (text, key) => text.match(new RegExp(`^${key} = "(.*)"$`, "m"))?.[1] ?? "";

/** The files that a study names, with their texts. */
function inputs(text) {
  const names = [...text.matchAll(/"(data\/[^"]+)"/g)].map(([, name]) => name);
  const here = names.filter((name) => existsSync(join(studies, name)));
  return Object.fromEntries(here.map((name) => [name, readFileSync(join(studies, name), "utf8")]));
}

function* filesOf(folder) {
  for (const name of readdirSync(folder).sort()) {
    const path = join(folder, name);
    if (statSync(path).isDirectory()) yield* filesOf(path);
    else yield path;
  }
}

const [looks, ...others] = readFileSync(join(root, "crates/report/page/style.css"), "utf8").split("/* Up to here");
if (others.length !== 1) throw new Error("the style of reports does not say up to where the site has it too");
const style = join(site, "style.css");
writeFileSync(style, looks + readFileSync(style, "utf8"));

mkdirSync(join(site, "gallery"));
const gallery = readdirSync(studies).filter((name) => name.endsWith(".toml")).sort().map((file) => {
  const name = file.slice(0, -".toml".length);
  const text = readFileSync(join(studies, file), "utf8");
  const picture = `gallery/${name}.svg`;
  copyFileSync(join(root, "docs/gallery/pictures", `${name}.svg`), join(site, picture));
  return { name, title: value(text, "title"), question: value(text, "question"), kind: value(text, "kind"), picture, text, files: inputs(text) };
});
writeFileSync(join(site, "gallery.json"), JSON.stringify(gallery));

const [, digest, units] = readFileSync(join(root, "docs/dev/verified-devices.md"), "utf8").match(/`([0-9a-f]{16})` with `--trials (\d+)`/);
writeFileSync(join(site, "verified.json"), JSON.stringify({ [units]: digest }));
mkdirSync(join(site, "example"));
const example = join(site, "example/gyro_at_rest.csv");
copyFileSync(join(studies, "data/gyro_at_rest.csv"), example);

// All reports have the same script, which the content security policy names by its digest.
const request = { call: "allan", name: "gyro_at_rest.csv", options: { rate: "1 Hz" }, simulated: 0 };
const report = instance(join(site, "sagnac.wasm"))(request, [readFileSync(example)]).blobs[0].toString();
const scripts = [...report.matchAll(/<script>(.*?)<\/script>/gs)].map(([, script]) => script);
if (scripts.length !== 1) throw new Error(`a report has ${scripts.length} scripts, expected one`);
const index = join(site, "index.html");
const page = readFileSync(index, "utf8");
const allowed = `'sha256-${createHash("sha256").update(scripts[0]).digest("base64")}'`;
if (!/'sha256-[^']*'/.test(page)) throw new Error("index.html has no digest to replace");
writeFileSync(index, page.replace(/'sha256-[^']*'/, allowed));

// The service worker compares each file with its digest. It is not in the list itself.
const list = [...filesOf(site)].map((path) => ({
  path: relative(site, path),
  sha256: createHash("sha256").update(readFileSync(path)).digest("hex"),
}));
const files = JSON.stringify(list.filter(({ path }) => path !== "sw.js"));
writeFileSync(join(site, "files.json"), files);
const worker = readFileSync(join(site, "sw.js"), "utf8");
if (!worker.includes('"development"')) throw new Error("sw.js has no version to replace");
writeFileSync(join(site, "sw.js"), worker.replace('"development"', `"${createHash("sha256").update(files).digest("hex")}"`));
