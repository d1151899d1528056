// The engine: instances of the program in workers, which share nothing. A study is divided into shares, one for each worker, or runs on
// the GPU of the browser.

import { openGpu, sampleOnGpu } from "./gpu.js";

/** The least module that uses SIMD128; browsers without it call it invalid. */
const SIMD_MODULE = Uint8Array.of(0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11);

const MOST_WORKERS = 8;

/** A message of the program: `kind` is "usage", "record", "study", "other", or "stopped" where the program did not end by itself. */
export class Failure extends Error {
  constructor({ text, kind, line, column }) {
    super(text);
    Object.assign(this, { kind, line, column });
  }
}

async function compile() {
  // With ?portable both can be compared in one browser.
  const isPortable = new URLSearchParams(location.search).has("portable") || !WebAssembly.validate(SIMD_MODULE);
  const url = isPortable ? "sagnac.wasm" : "sagnac_simd.wasm";
  try {
    return await WebAssembly.compileStreaming(fetch(url));
  } catch {
    // Some file servers do not name the type of the file.
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url} could not be loaded (${response.status})`);
    return WebAssembly.compile(await response.arrayBuffer());
  }
}

/** A worker that answers one request at a time. */
class Instance {
  constructor(module) {
    this.worker = new Worker("worker.js");
    this.worker.onerror = ({ message }) => { this.failure = message ?? "The worker could not start"; };
    this.worker.postMessage({ module });
  }

  run({ request, blobs, isGiven, progress }) {
    const stopped = (text) => ({ reply: { error: { kind: "stopped", text } } });
    return new Promise((resolve) => {
      if (this.failure) resolve(stopped(this.failure));
      this.worker.onmessage = ({ data }) => {
        if (data.progress) progress?.(...data.progress);
        else resolve(data);
      };
      this.worker.onerror = ({ message }) => resolve(stopped(message ?? "The worker could not start"));
      try {
        this.worker.postMessage({ request, blobs }, isGiven ? blobs.map((blob) => blob.buffer) : []);
      } catch ({ message }) {
        resolve(stopped(message));
      }
    });
  }
}

/** Workers on the processor, and the GPU where there is one. */
class Engine {
  /** Workers that take shares of a study; one more answers where there is only one of them. */
  shares = Math.max(1, Math.min(navigator.hardwareConcurrency || 2, MOST_WORKERS));
  #most = Math.max(2, this.shares);
  #idle = [];
  #queue = [];
  #count = 0;
  #module = compile();
  #gpu = openGpu().catch(() => null);

  /** Version of the program, and width of its vectors. */
  about = this.ask({ call: "about" }).then(({ reply }) => reply);

  /** Answers `{reply, blobs}`, or throws a `Failure`. A signal stops the work by ending its worker. Blobs that are given away are not copied. */
  ask(request, { blobs = [], isGiven = false, progress, signal } = {}) {
    return new Promise((resolve, reject) => {
      if (signal?.aborted) return reject(signal.reason);
      this.#queue.push({ request, blobs, isGiven, progress, signal, resolve, reject });
      this.#next();
    });
  }

  /** Starts the workers before there is work for all of them. */
  async warm() {
    const module = await this.#module;
    for (; this.#count < this.#most; this.#count += 1) this.#idle.push(new Instance(module));
  }

  /** Trials of a study: the rows that `outcome` takes, and who made them. */
  async sample(study, options) {
    const gpu = await this.#gpu;
    if (gpu) {
      try {
        return { rows: await sampleOnGpu(this, gpu, study, options), by: `WebGPU on ${gpu.name}` };
      } catch (error) {
        if (options.signal?.aborted || error.kind === "study") throw error;
        // What the program refuses, another study may not; a GPU that fails is left alone.
        if (!(error instanceof Failure)) this.#gpu = null;
        return this.#onWorkers(study, options, `; not on WebGPU: ${error.message.split("\n")[0]}`);
      }
    }
    return this.#onWorkers(study, options);
  }

  /** Names the number of workers and the width of their vectors. */
  async description() {
    const { lanes } = await this.about;
    return `${this.shares === 1 ? "1 worker" : `${this.shares} workers`}, ${lanes}`;
  }

  async #onWorkers(study, { trials, ...options }, why = "") {
    const answers = await this.#divided({ call: "share", ...study, trials }, options);
    return { rows: answers.map(({ blobs }) => blobs[0]), by: `${await this.description()}${why}` };
  }

  /** A part of the records that are simulated for the intervals of a log, from one number to another: the sums of each worker's. */
  async simulate(log, options) {
    return (await this.#divided({ call: "simulate", ...log }, options)).map(({ blobs }) => blobs);
  }

  /** The answers of all workers to a request, each for its share. */
  #divided(request, { blobs, progress, signal }) {
    const parts = Array.from({ length: this.shares }, () => [0, 0]);
    const sum = (which) => parts.reduce((total, part) => total + part[which], 0);
    return Promise.all(parts.map((_, at) => this.ask({ ...request, number: at + 1, of: this.shares }, {
      blobs,
      signal,
      progress: (...part) => {
        parts[at] = part;
        progress?.(sum(0), sum(1));
      },
    })));
  }

  /** The digests of the kernels as `verify` answers them, compared with the GPU too, and its name; null without one. */
  async verifyOnGpu(units, { signal, progress }) {
    const gpu = await this.#gpu;
    if (!gpu) return null;
    const noted = await this.ask({ call: "gpu_verify_dispatches", units }, { signal });
    const answers = await gpu.run(noted.reply, noted.blobs, { signal, progress });
    const { reply } = await this.ask({ call: "gpu_verify", units }, { blobs: answers, isGiven: true, signal });
    return { name: gpu.name, ...reply };
  }

  async #next() {
    let module;
    try {
      module = await this.#module;
    } catch (error) {
      this.#queue.splice(0).forEach((task) => task.reject(new Failure({ kind: "stopped", text: `The program could not be loaded: ${error.message}` })));
      return;
    }
    while (this.#queue.length > 0 && (this.#idle.length > 0 || this.#count < this.#most)) {
      const task = this.#queue.shift();
      if (task.signal?.aborted) {
        task.reject(task.signal.reason);
        continue;
      }
      if (this.#idle.length === 0) this.#count += 1;
      this.#work(this.#idle.pop() ?? new Instance(module), task);
    }
  }

  async #work(instance, task) {
    const end = () => {
      this.#remove(instance);
      task.reject(task.signal.reason);
    };
    task.signal?.addEventListener("abort", end);
    const { reply, blobs } = await instance.run(task);
    task.signal?.removeEventListener("abort", end);
    if (reply.error?.kind === "stopped") {
      this.#remove(instance);
    } else {
      this.#idle.push(instance);
      this.#next();
    }
    if (reply.error) task.reject(new Failure(reply.error));
    else task.resolve({ reply, blobs });
  }

  /** An instance that was stopped, or stopped by itself, is replaced when work needs another. */
  #remove(instance) {
    instance.worker.terminate();
    this.#count -= 1;
    this.#next();
  }
}

export const engine = new Engine();

export const isStopped = (error) => error.name === "AbortError";
