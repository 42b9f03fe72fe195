// The network in C, compiled to WebAssembly. dsnn/native/dsnn.h documents its functions and the order of its fields.

/**
 * @typedef {object} Params Fields of dsnn.DSNNParams.
 * @property {number} n_p
 * @property {number} u
 * @property {number} d
 * @property {number} n_con
 * @property {number} w_i
 * @property {number} sigma_l
 * @property {number} tau_fast
 * @property {number} tau_slow
 * @property {[number, number]} tau_s
 * @property {number} tau_mp
 * @property {number} k_sig
 * @property {number} k_sp
 * @property {number} t_sp
 * @property {number} fps
 * @property {boolean} on
 * @property {boolean} off
 * @property {boolean} dog
 * @property {boolean} fdsr
 * @property {boolean} rectified
 * @property {string} polarity
 * @property {string} lowpass
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
 * @typedef {object} Layers Maps of the last frame, row by row.
 * @property {Float32Array} p
 * @property {Float32Array} la
 * @property {Float32Array} fOn
 * @property {Float32Array} fOff
 *
 * @typedef {object} Series The answers to a clip, an entry a frame.
 * @property {Float64Array} hs
 * @property {Float64Array} vs
 * @property {Int32Array} hsSpikes
 * @property {Int32Array} vsSpikes
 * @property {{change: number, lamina: number, f: number}} largest Values of the maps, of every eighth frame.
 *
 * @typedef {{memory: WebAssembly.Memory} & Record<string, (...values: number[]) => number>} Kernel
 */

const SAMPLED = 8;
const SLICE = 32;

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
    const config = kernel.malloc(112);
    const view = new DataView(kernel.memory.buffer, config, 112);
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

  /** Return to the state before the first frame. */
  reset() {
    this.kernel.dsnn_reset(this.model);
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

/**
 * Show a whole clip to a new network.
 * @param {Kernel} kernel
 * @param {Tables} tables
 * @param {Clip} clip
 * @param {Params} params
 * @param {() => Promise<boolean>} [pause] Lets others work, and tells whether to go on.
 * @returns {Promise<Series | null>} null where it was not to go on.
 */
export async function run(kernel, tables, clip, params, pause) {
  const count = clip.frames.length;
  const network = new Network(kernel, tables, clip, params);
  const [hs, vs] = [new Float64Array(count), new Float64Array(count)];
  const [hsSpikes, vsSpikes] = [new Int32Array(count), new Int32Array(count)];
  const largest = { change: 1, lamina: 1, f: 0.1 };
  let goesOn = true;
  for (let i = 0; i < count && goesOn; i++) {
    const answer = network.step(clip.frames[i]);
    hs[i] = answer.getFloat64(0, true);
    vs[i] = answer.getFloat64(8, true);
    hsSpikes[i] = answer.getInt32(16, true);
    vsSpikes[i] = answer.getInt32(20, true);
    if (i % SAMPLED === 0) {
      const { p, la, fOn, fOff } = network.maps();
      largest.change = p.reduce((most, value) => Math.max(most, Math.abs(value)), largest.change);
      largest.lamina = la.reduce((most, value) => Math.max(most, Math.abs(value)), largest.lamina);
      largest.f = [fOn, fOff].reduce((most, map) => map.reduce((m, value) => Math.max(m, value), most), largest.f);
    }
    if (pause && i % SLICE === SLICE - 1) goesOn = await pause();
  }
  network.free();
  return goesOn ? { hs, vs, hsSpikes, vsSpikes, largest } : null;
}
