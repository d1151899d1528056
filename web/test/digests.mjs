// What a browser must compute to the bit: tables of a study of each kind as the golden tables have them, and tables and pages of
// logs as the program writes them.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("../../", import.meta.url));
const read = (path) => readFileSync(join(root, path));
export const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** Number of trials of the golden tables, which studies of fewer than 256 trials do not have. */
const TRIALS = 512;

/** Studies of each kind, some with files; lock-in has few trials. */
const STUDIES = [
  "smoke", "design_point", "sawtooth", "relock_noise", "quantizer", "lgk400_vs_lgv1", "lgv1_lock_in", "optimal_interval", "suspension",
  "gyrocompass",
];

/** Logs of each format, with the options of the page and those of the program. */
const LOGS = [
  ["studies/data/gyro_at_rest.csv", { rate: "1 Hz" }, ["--rate", "1Hz"]],
  ["tests/data/formats/imu.mcap", { column: "gx" }, ["--column", "gx"]],
  ...["imu.csv", "imu.npy", "imu.npz", "imu_packed.mat", "imu_v73.mat"].map((name) => [`tests/data/formats/${name}`, ...options(name)]),
];

function options(name) {
  if (name.endsWith(".csv")) return [{ data: "rate", column: "gx" }, ["--data", "rate", "--column", "gx"]];
  return [{ data: "rate", unit: "rad/s", column: "2", rate: "200 Hz" }, ["--data", "rate", "--unit", "rad/s", "--column", "2", "--rate", "200Hz"]];
}

/** The studies as requests, with the digest of their points. */
export function studies(gallery) {
  const goldens = read("tests/data/tables.sha256").toString();
  return STUDIES.map((name) => {
    const { text, files } = gallery.find((study) => study.name === name);
    const own = Number(text.match(/^trials = ([\d_]+)/m)?.[1].replaceAll("_", "") ?? TRIALS);
    const [, expected] = goldens.match(new RegExp(`([0-9a-f]{64})  ${name}/points.csv`));
    return { name, study: { text, name: `${name}.toml`, files, trials: own < 256 ? own : TRIALS }, expected };
  });
}

/** The page that the program writes of a study, once its results are complete. */
export function pageOf(program, { name, trials }) {
  const folder = mkdtempSync(join(tmpdir(), "sagnac-study-"));
  execFileSync(program, ["run", name, "--trials", trials, "--device", "cpu", "--out", folder, "--quiet"], { cwd: join(root, "studies") });
  execFileSync(program, ["report", folder, "--quiet"]);
  const page = readFileSync(join(folder, "report.html"));
  rmSync(folder, { recursive: true });
  return page;
}

/** A page without the machine and the seconds that its trials took, in which alone two runs of the program differ. */
export const withoutMachine = (page) => page.toString().replace(/<dt>Sampled<\/dt>\s*<dd>.*?<\/dd>/s, "");

/** The logs as requests, with the digests of the files that the program writes, with intervals in closed form unless they are `simulated`. */
export function logs(program, { simulated = false } = {}) {
  const closed = simulated ? [] : ["--bootstrap", "0"];
  return LOGS.slice(0, simulated ? 2 : LOGS.length).map(([path, given, words]) => {
    const folder = mkdtempSync(join(tmpdir(), "sagnac-log-"));
    // Only the name of the file is known in a browser.
    execFileSync(program, ["allan", path.split("/").at(-1), ...words, ...closed, "--out", folder, "--quiet"], {
      cwd: join(root, path, ".."),
    });
    const expected = Object.fromEntries(["report.html", "coefficients.csv", "curve.csv"].map((name) => [name, sha256(readFileSync(join(folder, name)))]));
    rmSync(folder, { recursive: true });
    return { name: path.split("/").at(-1), bytes: read(path), options: given, expected };
  });
}

/** The digest of all kernels with 4096 units of work. */
export function kernels() {
  return read("docs/dev/verified-devices.md").toString().match(/`([0-9a-f]{16})` with `--trials 4096`/)[1];
}

/** Runs in the page: the digest of the points of a study, on so many workers or, with 0, on the GPU. */
export async function pointsOf(study, trials, workers) {
  const { engine } = await import("/engine.js");
  if (workers > 0) engine.shares = workers;
  const { rows, by } = await engine.sample(study, { trials });
  const { reply } = await engine.ask({ call: "outcome", ...study, trials, complete: false }, { blobs: rows });
  return by.startsWith(workers > 0 ? `${workers} worker` : "WebGPU on") && !by.includes(";") ? reply.digest : by;
}

/** Runs in the page: the digest of all kernels with 4096 units of work, and the width of the vectors. */
export async function digestOfKernels() {
  const { engine } = await import("/engine.js");
  const { digest, rows } = (await engine.ask({ call: "verify", units: 4096 })).reply;
  const other = rows.filter(({ identical }) => !identical).map(({ kernel }) => kernel);
  return other.length === 0 ? `${digest} by ${(await engine.about).lanes}` : `another width differs in ${other.join(", ")}`;
}

/** Prints whether a result is the expected one, and returns it. */
export function agrees(name, found, expected) {
  console.log(found === expected ? `ok ${name}` : `FAIL ${name}: ${found}, expected ${expected}`);
  return found === expected;
}
