// The network in C, compiled to WebAssembly. dsnn/native/dsnn.h documents its functions and the order of its fields.

/**
 * @typedef {Record<string, any>} Params Fields of dsnn.DSNNParams.
 *
 * @typedef {object} Tables Numbers that Python computes: they need its exponential.
 * @property {number[]} residues a_1, a_2, ... of the paper's u.
 * @property {Record<string, number[]>} kernels Width of a Gaussian, px -> one half of it, its centre first.
 *
 * @typedef {object} Clip
 * @property {number} rows
 * @property {number} columns
 * @property {Uint8Array[]} frames Grey levels, row by row.
 *
 * @typedef {Record<"p" | "la" | "fOn" | "fOff", Float32Array>} Layers Maps of a frame, row by row.
 *
 * @typedef {Record<"hs" | "vs" | "hsSpikes" | "vsSpikes", number[]>} Answers To a clip, an entry a frame.
 * @typedef {Answers & {largest: {change: number, lamina: number, f: number}}} Series The largest magnitudes of kept maps.
 *
 * @typedef {{memory: WebAssembly.Memory} & Record<string, (...values: number[]) => number>} Kernel
 */

const SLICE = 16;

/**
 * Compile the network.
 * @param {BufferSource} bytes
 * @returns {Promise<Kernel>}
 */
export async function compile(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes);
  const kernel = /** @type {Kernel} */ (/** @type {unknown} */ (instance.exports));
  kernel._initialize();
  return kernel;
}

/**
 * Compute the gain of a low-pass with time constant `tau`, ms, as DSNNParams.alpha does.
 * @param {Params} params
 * @param {number} tau
 */
function alpha(params, tau) {
  if (params.lowpass !== "backward-euler") throw new Error(`lowpass=${params.lowpass}: legal here is backward-euler`);
  const dt = 1000 / params.fps;
  return dt / (dt + tau);
}

/** A network at work: its memory, and the way a frame gets to it. */
export class Network {
  /**
   * @param {Kernel} kernel
   * @param {Tables} tables
   * @param {{rows: number, columns: number}} shape
   * @param {Params} params
   */
  constructor(kernel, tables, shape, params) {
    this.kernel = kernel;
    this.cells = shape.rows * shape.columns;
    const { n_con, d, n_p, tau_s } = params;
    const span = Math.max(n_con - 1, 1);
    const delays = Array.from({ length: n_con }, (_, j) => tau_s[0] + ((tau_s[1] - tau_s[0]) * j) / span);
    const residues = tables.residues.slice(0, n_p);
    const kernels = [d, 2 * d].map((width) => tables.kernels[width]);
    const alphas = delays.map((tau) => alpha(params, tau));
    const given = [residues, ...kernels, alphas].map((table) => this.#floats(table));
    const config = kernel.malloc(120);
    const view = new DataView(kernel.memory.buffer, config, 120);
    view.setBigInt64(112, 0n, true); // no low-pass of two taps here
    [
      ...[shape.rows, shape.columns, n_p, d, n_con, params.on, params.off, params.dog, params.fdsr, params.rectified],
      params.polarity === "common",
    ].forEach((value, i) => {
      view.setInt32(4 * i, Number(value), true);
    });
    const left = [params.tau_fast, params.tau_slow].map((tau) => 1 - alpha(params, tau));
    [params.w_i, params.sigma_l, ...left].forEach((value, i) => {
      view.setFloat32(44 + 4 * i, value, true);
    });
    [alpha(params, params.tau_mp), this.cells * params.k_sig, params.k_sp, params.t_sp].forEach((value, i) => {
      view.setFloat64(64 + 8 * i, value, true);
    });
    given.forEach((pointer, i) => {
      view.setInt32(96 + 4 * i, pointer, true);
    });
    const size = kernel.dsnn_size(config);
    this.memory = kernel.malloc(size);
    this.model = kernel.dsnn_make(this.memory, size, config);
    for (const pointer of [...given, config]) kernel.free(pointer);
    this.frame = kernel.malloc(this.cells);
    this.answer = kernel.malloc(24);
    this.layers = kernel.malloc(16 * this.cells);
  }

  /** @param {number[]} table */
  #floats(table) {
    const pointer = this.kernel.malloc(4 * Math.max(table.length, 1));
    new Float32Array(this.kernel.memory.buffer, pointer, table.length).set(table);
    return pointer;
  }

  /**
   * Answer the next frame; the view has HS, VS (float64) and their spikes (int32), until the next step.
   * @param {Uint8Array} frame
   */
  step(frame) {
    new Uint8Array(this.kernel.memory.buffer, this.frame, this.cells).set(frame);
    this.kernel.dsnn_step_u8(this.model, this.frame, this.answer);
    return new DataView(this.kernel.memory.buffer, this.answer, 24);
  }

  /**
   * Read the maps of the last frame; they are overwritten by the next call.
   * @returns {Layers}
   */
  maps() {
    const at = [0, 1, 2, 3].map((i) => this.layers + 4 * i * this.cells);
    this.kernel.dsnn_maps(this.model, ...at);
    const [p, la, fOn, fOff] = at.map((begin) => new Float32Array(this.kernel.memory.buffer, begin, this.cells));
    return { p, la, fOn, fOff };
  }

  /** Give the memory back. */
  free() {
    for (const pointer of [this.memory, this.frame, this.answer, this.layers]) this.kernel.free(pointer);
  }
}

/** The answers of a new network to a clip that may still grow. */
export class Run {
  /**
   * @param {Kernel} kernel
   * @param {Tables} tables
   * @param {Clip} clip
   * @param {Params} params
   * @param {boolean} [keeps] Whether to keep the maps of every frame.
   */
  constructor(kernel, tables, clip, params, keeps = false) {
    this.clip = clip;
    this.keeps = keeps;
    this.network = new Network(kernel, tables, clip, params);
    /** @type {Series} */
    this.series = { hs: [], vs: [], hsSpikes: [], vsSpikes: [], largest: { change: 1, lamina: 1, f: 0.1 } };
    /** @type {Layers[]} */
    this.layers = [];
  }

  /**
   * Show the next frames, as many as there are or up to a number in all.
   * @param {number} [until]
   */
  advance(until = Number.POSITIVE_INFINITY) {
    const { hs, vs, hsSpikes, vsSpikes, largest } = this.series;
    for (let i = hs.length; i < Math.min(until, this.clip.frames.length); i++) {
      const answer = this.network.step(this.clip.frames[i]);
      hs.push(answer.getFloat64(0, true));
      vs.push(answer.getFloat64(8, true));
      hsSpikes.push(answer.getInt32(16, true));
      vsSpikes.push(answer.getInt32(20, true));
      if (!this.keeps) continue;
      const [p, la, fOn, fOff] = Object.values(this.network.maps()).map((map) => map.slice());
      this.layers.push({ p, la, fOn, fOff });
      largest.change = size(p, largest.change);
      largest.lamina = size(la, largest.lamina);
      largest.f = size(fOff, size(fOn, largest.f));
    }
    return hs.length === this.clip.frames.length;
  }

  /**
   * Show the whole clip, in small parts, and give the memory back; null where `pause` says not to go on.
   * @param {() => Promise<boolean>} pause Lets others work.
   */
  async finish(pause) {
    let goesOn = true;
    while (goesOn && !this.advance(this.series.hs.length + SLICE)) goesOn = await pause();
    this.network.free();
    return goesOn ? this.series : null;
  }
}

/**
 * Find the largest magnitude of a map, if it is above another number.
 * @param {Float32Array} map
 * @param {number} least
 */
function size(map, least) {
  let most = least;
  for (let i = 0; i < map.length; i++) most = Math.max(most, Math.abs(map[i]));
  return most;
}
