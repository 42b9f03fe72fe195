// Pictures: maps on canvases, traces and the curve of counts as SVG.

/**
 * @typedef {import("#network").Series} Series
 * @typedef {import("#network").Clip} Clip
 */

const [BRIGHTER, DARKER] = ["brighter", "darker"].map(colourOf);
const TALLEST = 3;

/**
 * Paint an image, one pixel a cell.
 * @param {HTMLCanvasElement} canvas
 * @param {{rows: number, columns: number}} shape
 * @param {(cell: number) => number} colour Of a cell: red + 256 green + 65536 blue.
 */
function paint(canvas, shape, colour) {
  const { rows, columns } = shape;
  if (canvas.width !== columns || canvas.height !== rows) [canvas.width, canvas.height] = [columns, rows];
  const pixels = new Uint32Array(rows * columns);
  for (let i = 0; i < pixels.length; i++) pixels[i] = 0xff000000 + colour(i);
  const image = new ImageData(new Uint8ClampedArray(pixels.buffer), columns, rows);
  canvas.getContext("2d")?.putImageData(image, 0, 0);
}

/**
 * Read a colour of the page, as red, green and blue.
 * @param {string} name
 */
function colourOf(name) {
  const hex = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  return [1, 3, 5].map((place) => Number.parseInt(hex.slice(place, place + 2), 16));
}

/**
 * Mix a colour that grows with the root of two shares, so that what is faint is seen.
 * @param {number} brighter Share of the largest value.
 * @param {number} darker
 */
function tint(brighter, darker) {
  const [on, off] = [Math.sqrt(Math.max(0, Math.min(1, brighter))), Math.sqrt(Math.max(0, Math.min(1, darker)))];
  const part = (/** @type {0 | 1 | 2} */ i) => Math.min(255, Math.round(BRIGHTER[i] * on + DARKER[i] * off));
  return part(0) + 256 * part(1) + 65536 * part(2);
}

/** @param {number} level */
const grey = (level) => 0x10101 * Math.max(0, Math.min(255, Math.round(level)));

/**
 * Paint a frame and the four maps that the network makes of it.
 * @param {Record<string, HTMLCanvasElement>} canvases
 * @param {Clip} clip
 * @param {number} frame
 * @param {import("#network").Layers} layers
 * @param {Series["largest"]} largest
 */
export function paintMaps(canvases, clip, frame, layers, largest) {
  const { p, la, fOn, fOff } = layers;
  const luma = clip.frames[frame];
  paint(canvases.frame, clip, (i) => grey(luma[i]));
  paint(canvases.change, clip, (i) => grey(128 + 127 * Math.sign(p[i]) * Math.sqrt(Math.abs(p[i]) / largest.change)));
  paint(canvases.on, clip, (i) => tint(la[i] / largest.lamina, 0));
  paint(canvases.off, clip, (i) => tint(0, -la[i] / largest.lamina));
  paint(canvases.f, clip, (i) => tint(fOn[i] / largest.f, fOff[i] / largest.f));
}

/**
 * Draw potentials and spikes over a whole trial.
 * @param {SVGSVGElement} svg
 * @param {Series} series
 * @param {Series | null} ghost The trial's own params; null where nothing differs.
 * @param {number} threshold
 * @param {number} fps
 * @returns {(frame: number) => void} Moves the playhead.
 */
export function drawTraces(svg, series, ghost, threshold, fps) {
  const [width, height] = [svg.clientWidth, svg.clientHeight];
  const [left, right, top, raster] = [38, width - 8, 8, height < 200 ? 22 : 30];
  const floor = height - 24 - 2 * raster;
  const last = Math.max(series.hs.length - 1, 1);
  const x = (/** @type {number} */ frame) => left + ((right - left) * frame) / last;
  const y = (/** @type {number} */ potential) => top + ((floor - top) * (1 - potential)) / 2;
  const line = (/** @type {number[]} */ values, /** @type {string} */ kind) =>
    `<polyline class="${kind}" points="${Array.from(values, (v, i) => `${x(i).toFixed(1)},${y(v).toFixed(1)}`).join(" ")}"/>`;
  const level = (/** @type {number} */ value, /** @type {string} */ text, /** @type {string} */ kind) =>
    `<line class="${kind}" x1="${left}" x2="${right}" y1="${y(value)}" y2="${y(value)}"/>` +
    `<text x="${left - 6}" y="${y(value) + 4}" text-anchor="end">${text}</text>`;
  const bars = (/** @type {number[]} */ spikes, /** @type {number} */ row, /** @type {string} */ kind) => {
    const base = floor + 8 + row * raster + raster / 2;
    const wide = Math.max(1, Math.min(5, (right - left) / last - 0.6));
    const marks = Array.from(spikes, (count, i) => {
      const tall = ((raster / 2 - 2) * (1 + Math.min(Math.abs(count), TALLEST))) / (1 + TALLEST);
      return count
        ? `<rect x="${(x(i) - wide / 2).toFixed(1)}" y="${count > 0 ? base - tall : base}" width="${wide.toFixed(1)}" height="${tall}"/>`
        : "";
    });
    return (
      `<g class="${kind}"><line x1="${left}" x2="${right}" y1="${base}" y2="${base}"/>${marks.join("")}</g>` +
      `<text x="${left - 6}" y="${base + 4}" text-anchor="end">${kind.toUpperCase()}</text>`
    );
  };
  const isTight = y(0) - y(threshold) < 14;
  const seconds = last / fps;
  const spacing = [0.5, 1, 2, 5].find((each) => seconds / each <= Math.max(4, width / 90)) ?? 10;
  const ticks = Array.from({ length: Math.floor(seconds / spacing) + 1 }, (_, i) => i * spacing).map(
    (s) => `<text x="${x(s * fps)}" y="${height - 4}" text-anchor="middle">${s}${s ? "" : " s"}</text>`,
  );
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.innerHTML =
    `<rect class="below" x="${left}" width="${right - left}" y="${y(threshold)}" height="${y(-threshold) - y(threshold)}"/>` +
    level(1, "1", "grid") +
    level(0, isTight ? "\u00b1T" : "0", "axis") +
    level(-1, "\u22121", "grid") +
    level(threshold, isTight ? "" : "+T", "threshold") +
    level(-threshold, isTight ? "" : "\u2212T", "threshold") +
    (ghost ? line(ghost.vs, "ghost vs") + line(ghost.hs, "ghost hs") : "") +
    line(series.vs, "vs") +
    line(series.hs, "hs") +
    bars(series.hsSpikes, 0, "hs") +
    bars(series.vsSpikes, 1, "vs") +
    ticks.join("") +
    `<line class="playhead" y1="${top}" y2="${height - 20}"/>`;
  const playhead = /** @type {SVGLineElement} */ (svg.querySelector(".playhead"));
  return (frame) => {
    for (const end of ["x1", "x2"]) playhead.setAttribute(end, String(x(frame)));
  };
}

/**
 * Tell which frame of the traces is at a place of the window.
 * @param {SVGSVGElement} svg
 * @param {number} clientX
 * @param {number} count
 */
export function frameAt(svg, clientX, count) {
  const share = (clientX - svg.getBoundingClientRect().left - 38) / (svg.clientWidth - 46);
  return Math.round(Math.max(0, Math.min(1, share)) * (count - 1));
}

/**
 * Draw spikes against speed.
 * @param {SVGSVGElement} svg
 * @param {Map<number, number>} counts Speed, cm/s -> spikes.
 * @param {Map<number, number>} defaults The same of the runs.
 */
export function drawCurve(svg, counts, defaults) {
  const [width, height] = [svg.clientWidth, svg.clientHeight];
  const [left, right, top, floor] = [38, width - 20, 22, height - 36];
  const fastest = Math.max(...defaults.keys());
  const most = Math.max(10, ...counts.values(), ...defaults.values());
  const unit = [10, 20, 50, 100, 200, 500].find((each) => most / each <= 5) ?? 1000;
  const ceiling = unit * Math.ceil(most / unit);
  const x = (/** @type {number} */ speed) => left + ((right - left) * speed) / fastest;
  const y = (/** @type {number} */ count) => floor - ((floor - top) * count) / ceiling;
  const curve = (/** @type {Map<number, number>} */ values, /** @type {string} */ kind) => {
    const points = [...values].map(([speed, count]) => `${x(speed)},${y(count)}`);
    const dots = [...values].map(([speed, count]) => `<circle cx="${x(speed)}" cy="${y(count)}" r="5"/>`);
    return `<g class="${kind}"><polyline points="${points.join(" ")}"/>${dots.join("")}</g>`;
  };
  const levels = Array.from({ length: ceiling / unit + 1 }, (_, i) => i * unit).map(
    (count) =>
      `<line class="grid" x1="${left}" x2="${right}" y1="${y(count)}" y2="${y(count)}"/>` +
      `<text x="${left - 6}" y="${y(count) + 4}" text-anchor="end">${count}</text>`,
  );
  const speeds = [...defaults.keys()].map(
    (speed) => `<text x="${x(speed)}" y="${floor + 18}" text-anchor="middle">${speed}</text>`,
  );
  const labels = [...counts].map(
    ([speed, count]) => `<text class="count" x="${x(speed)}" y="${y(count) - 10}" text-anchor="middle">${count}</text>`,
  );
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.innerHTML =
    `${levels.join("")}${speeds.join("")}<text x="${(left + right) / 2}" y="${height - 2}" text-anchor="middle">speed, cm/s</text>` +
    curve(defaults, "ghost") +
    curve(counts, "now") +
    labels.join("");
}
