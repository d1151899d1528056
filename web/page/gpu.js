// The GPU of the browser. It runs dispatches that the program has noted, and its answers go back to the program in their order.

/** Most bytes of the answers of a run, which are in memory together. */
const MOST_BYTES = 512 * 2 ** 20;

const SCOPES = ["validation", "out-of-memory", "internal"];

/** A GPU on which shares of studies run, or null where the browser offers none, or only one in software: processors are faster. */
export async function openGpu() {
  const adapter = await navigator.gpu?.requestAdapter({ powerPreference: "high-performance" });
  // With ?webgpu one in software is used too, for tests.
  const isTested = new URLSearchParams(location.search).has("webgpu");
  if (!adapter || ((adapter.info?.isFallbackAdapter || /swiftshader|llvmpipe|software/i.test(nameOf(adapter))) && !isTested)) return null;
  const device = await adapter.requestDevice();
  return new Gpu(device, nameOf(adapter));
}

function nameOf({ info: { vendor, architecture, description } = {} }) {
  return description || [vendor, architecture].filter(Boolean).join(" ") || "a GPU without a name";
}

/** Trials of a study on the GPU: the rows that `outcome` takes. Throws where the GPU fails, or computes other bits than a processor. */
export async function sampleOnGpu(engine, gpu, study, { trials, progress, signal }) {
  const share = { ...study, trials, number: 1, of: 1 };
  const noted = await engine.ask({ call: "gpu_dispatches", ...share }, { signal });
  const answers = await gpu.run(noted.reply, noted.blobs, { signal, progress });
  const { reply, blobs } = await engine.ask({ call: "gpu_share", ...share }, { blobs: answers, isGiven: true, signal });
  if (reply.notes.length > 0) throw new Error(reply.notes.join("; "));
  return blobs;
}

class Gpu {
  #pipelines = new Map();
  #normals = null;
  #lost = null;

  constructor(device, name) {
    this.device = device;
    this.name = name;
    device.lost.then(({ message }) => { this.#lost = message; });
  }

  /** The words that each dispatch writes, as bytes. `files` are those of the program's reply, the table of normal numbers first. */
  async run({ shaders, dispatches }, files, { signal, progress } = {}) {
    const words = dispatches.flatMap(({ outputs }) => outputs.map(([, count]) => count)).reduce((sum, count) => sum + count, 0);
    if (4 * words > MOST_BYTES) throw new Error("its answers would take more memory than a page has");
    this.#normals ??= this.#buffer(files[0], GPUBufferUsage.STORAGE);
    // Drivers compile several at a time; one that fails does so again at its dispatch.
    shaders.forEach((shader) => this.#pipeline(shader).catch(() => {}));
    const answers = [];
    for (const dispatch of dispatches) {
      signal?.throwIfAborted();
      if (this.#lost !== null) throw new Error(`the GPU was lost: ${this.#lost}`);
      answers.push(await this.#dispatch(shaders[dispatch.shader], dispatch, files));
      progress?.(answers.length, dispatches.length);
    }
    return answers;
  }

  /** Runs a dispatch. Errors of WebGPU are not exceptions: without these scopes a dispatch that failed would answer zeros. */
  async #dispatch(...dispatch) {
    const owned = [];
    SCOPES.forEach((scope) => this.device.pushErrorScope(scope));
    try {
      return await this.#answer(owned, ...dispatch);
    } catch (error) {
      // Mapping fails so where the GPU is lost; it is no stop of the reader's.
      throw new Error(`the GPU failed: ${error.message}`);
    } finally {
      owned.forEach((buffer) => buffer.destroy());
      const wrong = (await Promise.all(SCOPES.map(() => this.device.popErrorScope()))).find(Boolean);
      if (wrong) throw new Error(`the GPU refused the work: ${wrong.message}`);
    }
  }

  async #answer(owned, shader, { hasNormals, inputs, scratch, outputs, passes }, files) {
    const pipeline = await this.#pipeline(shader);
    const own = (buffer) => (owned.push(buffer), buffer);
    const bound = (binding, buffer) => ({ binding, resource: { buffer } });
    const results = outputs.map(([binding, words]) => ({
      binding, size: 4 * words, buffer: own(this.#zeros(words, GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC)),
    }));
    const entries = [
      ...(hasNormals ? [bound(0, this.#normals)] : []),
      ...inputs.map(([binding, file]) => bound(binding, own(this.#buffer(files[file], GPUBufferUsage.STORAGE)))),
      ...scratch.map(([binding, words]) => bound(binding, own(this.#zeros(words, GPUBufferUsage.STORAGE)))),
      ...results.map(({ binding, buffer }) => bound(binding, buffer)),
    ];
    const read = own(this.device.createBuffer({
      size: results.reduce((sum, { size }) => sum + size, 0), usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST,
    }));
    const layout = pipeline.getBindGroupLayout(0);
    for (const [at, { uniform, grid }] of passes.entries()) {
      const uniforms = uniform === null ? [] : [bound(1, own(this.#buffer(files[uniform], GPUBufferUsage.UNIFORM)))];
      const encoder = this.device.createCommandEncoder();
      const pass = encoder.beginComputePass();
      pass.setPipeline(pipeline);
      pass.setBindGroup(0, this.device.createBindGroup({ layout, entries: [...entries, ...uniforms] }));
      pass.dispatchWorkgroups(...grid);
      pass.end();
      if (at === passes.length - 1) {
        let place = 0;
        for (const { buffer, size } of results) {
          encoder.copyBufferToBuffer(buffer, 0, read, place, size);
          place += size;
        }
      }
      this.device.queue.submit([encoder.finish()]);
    }
    await read.mapAsync(GPUMapMode.READ);
    return new Uint8Array(read.getMappedRange().slice(0));
  }

  #pipeline(code) {
    if (!this.#pipelines.has(code)) {
      const module = this.device.createShaderModule({ code });
      const made = this.device.createComputePipelineAsync({ layout: "auto", compute: { module, entryPoint: "main" } });
      this.#pipelines.set(code, made);
      made.catch(() => this.#pipelines.delete(code));
    }
    return this.#pipelines.get(code);
  }

  #buffer(bytes, usage) {
    const buffer = this.device.createBuffer({ size: bytes.length, usage: usage | GPUBufferUsage.COPY_DST });
    this.device.queue.writeBuffer(buffer, 0, bytes);
    return buffer;
  }

  #zeros(words, usage) {
    return this.device.createBuffer({ size: 4 * words, usage });
  }
}
