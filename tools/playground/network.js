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
 * @property {number[]} hs
 * @property {number[]} vs
 * @property {number[]} hsSpikes
 * @property {number[]} vsSpikes
 * @property {{change: number, lamina: number, f: number}} largest Magnitudes of the maps, of every sixteenth frame.
 *
 * @typedef {{memory: WebAssembly.Memory} & Record<string, (...values: number[]) => number>} Kernel
 */

const SAMPLED = 16;
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

/** @param {Layers} layers That the next call overwrites. */
const copied = ({ p, la, fOn, fOff }) => ({ p: p.slice(), la: la.slice(), fOn: fOn.slice(), fOff: fOff.slice() });

/** The answers of a new network to a clip that may still grow. */
export class Run {
  /**
   * @param {Kernel} kernel
   * @param {Tables} tables
   * @param {Clip} clip
   * @param {Params} params
   */
  constructor(kernel, tables, clip, params) {
    this.clip = clip;
    this.network = new Network(kernel, tables, clip, params);
    /** @type {Series} */
    this.series = { hs: [], vs: [], hsSpikes: [], vsSpikes: [], largest: { change: 1, lamina: 1, f: 0.1 } };
    /** @type {Layers | null} */
    this.layers = null;
  }

  /**
   * Show the next frames, as many as there are or up to a number in all.
   * @param {number} [until]
   * @param {number} [kept] The frame whose maps `layers` is to keep.
   */
  advance(until = Number.POSITIVE_INFINITY, kept = -1) {
    const { hs, vs, hsSpikes, vsSpikes, largest } = this.series;
    for (let i = hs.length; i < Math.min(until, this.clip.frames.length); i++) {
      const answer = this.network.step(this.clip.frames[i]);
      hs.push(answer.getFloat64(0, true));
      vs.push(answer.getFloat64(8, true));
      hsSpikes.push(answer.getInt32(16, true));
      vsSpikes.push(answer.getInt32(20, true));
      if (i === kept) this.layers = copied(this.network.maps());
      if (i % SAMPLED) continue;
      const { p, la, fOn, fOff } = this.network.maps();
      largest.change = size(p, largest.change);
      largest.lamina = size(la, largest.lamina);
      largest.f = size(fOff, size(fOn, largest.f));
    }
    return hs.length === this.clip.frames.length;
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

/**
 * Compute the answers to a whole clip.
 * @param {Kernel} kernel
 * @param {Tables} tables
 * @param {Clip} clip
 * @param {Params} params
 * @param {{pause?: () => Promise<boolean>, kept?: number}} [how] `pause` lets others work, and tells whether to go on;
 *   `kept` is the frame whose maps are wanted.
 * @returns {Promise<{series: Series, layers: Layers | null} | null>} null where it was not to go on.
 */
export async function run(kernel, tables, clip, params, { pause, kept } = {}) {
  const work = new Run(kernel, tables, clip, params);
  let goesOn = true;
  while (goesOn && !work.advance(pause && work.series.hs.length + SLICE, kept)) goesOn = pause ? await pause() : true;
  work.network.free();
  return goesOn ? { series: work.series, layers: work.layers } : null;
}
