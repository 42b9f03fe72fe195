// The trials that the page was built with: what was recorded, and their frames.

/**
 * @typedef {import("#network").Clip} Clip
 * @typedef {import("#network").Params} Params
 *
 * @typedef {object} Recorded A trial as the generator describes it.
 * @property {string} id
 * @property {string} group
 * @property {string} title
 * @property {string} note
 * @property {number} rows
 * @property {number} columns
 * @property {number} count
 * @property {Params} params With which it was run.
 * @property {number} spikes Of HS, from trials.parquet of the run.
 * @property {string} command
 * @property {number | null} speed Where C15's curve has it, cm/s.
 */

/** @param {string} id An element of the page, whose text is base64. */
export function embedded(id) {
  const text = document.getElementById(id)?.textContent ?? "";
  return Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
}

/**
 * Unpack frames: zlib, each frame as the difference to the one before it.
 * @param {Uint8Array<ArrayBuffer>} packed
 * @param {number} cells
 * @returns {Promise<Uint8Array[]>}
 */
export async function unpack(packed, cells) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  for (let i = cells; i < bytes.length; i++) bytes[i] += bytes[i - cells];
  return Array.from({ length: bytes.length / cells }, (_, i) => bytes.subarray(i * cells, (i + 1) * cells));
}

/** @type {Map<string, Promise<Clip>>} */
const unpacked = new Map();

/** @param {Recorded} trial Its frames are loaded and unpacked once: a script beside the page has them. */
export function clip(trial) {
  const { id, rows, columns } = trial;
  const load = () => script(`play/${id}.js`).then(() => unpack(embedded(`frames-${id}`), rows * columns));
  const known = unpacked.get(id) ?? load().then((frames) => ({ rows, columns, frames }));
  unpacked.set(id, known);
  return known;
}

/** @param {string} src */
function script(src) {
  return new Promise((onload, fail) => {
    const onerror = () => fail(new Error(`${src} is not there`));
    document.head.append(Object.assign(document.createElement("script"), { src, onload, onerror }));
  });
}
