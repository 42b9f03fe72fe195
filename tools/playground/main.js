// The page: what is chosen, what follows from it, and where it is shown.
import { drawCurve, drawTraces, frameAt, paintMaps } from "#drawing";
import { LONGEST, opened, taken } from "#footage";
import { counted, judged, told } from "#judging";
import { compile, Run } from "#network";
import { assignments, changed, commandOf, read, settingOf, written } from "#settings";
import { clip as clipOf, embedded } from "#trials";

/**
 * @typedef {import("#network").Series} Series
 * @typedef {import("#network").Clip} Clip
 * @typedef {import("#trials").Recorded} Recorded
 * @typedef {import("#settings").Lever} Lever
 */

/**
 * Find an element that the page has.
 * @template {Element} Kind
 * @param {string} id
 * @param {new () => Kind} kind
 */
function the(id, kind) {
  const element = document.getElementById(id);
  if (!(element instanceof kind)) throw new Error(`the page has no ${kind.name} ${id}`);
  return element;
}

/**
 * @type {{trials: Recorded[], first: string, footage: Recorded, levers: Lever[], claim: import("#judging").Claim,
 *   tables: import("#network").Tables}}
 */
const data = JSON.parse(the("data", HTMLScriptElement).text);
const { levers, claim, tables } = data;
const kernel = await compile(embedded("wasm"));
const curve = data.trials.filter((trial) => trial.speed !== null);
const first = data.trials.find((each) => each.id === data.first) ?? data.trials[0];
const scrubber = the("scrubber", HTMLInputElement);
const tracesPicture = the("traces", SVGSVGElement);
const canvases = Object.fromEntries(
  ["frame", "change", "on", "off", "f"].map((id) => [id, the(id, HTMLCanvasElement)]),
);

/** @type {Recorded} */
let trial = first;
/** @type {Clip} */
let clip = { rows: trial.rows, columns: trial.columns, frames: [] };
/** @type {import("#settings").Changes} */
let changes = {};
let frame = 0;
/** @type {Run | null} What is shown, and the settings that it was computed with. */
let shown = null;
let settings = "";
let movePlayhead = (/** @type {number} */ _frame) => {};
let turn = 0;
let asked = false;
/** @type {Clip | null} */
let own = null;
/** @type {import("#footage").Taking | null} */
let taking = null;
/** @type {WeakMap<Clip, Series>} Answers with a trial's own params. */
const ghosts = new WeakMap();

const say = (/** @type {string} */ text) => {
  const message = the("message", HTMLElement);
  message.hidden = text === "";
  message.textContent = text;
};
const texts = () => assignments(trial.params, levers, changes);

/** Show the chosen frame, and the maps that the network has there. */
function showFrame() {
  if (shown?.clip !== clip || !shown.layers[frame]) return;
  const { series, layers } = shown;
  paintMaps(canvases, clip, frame, layers[frame], series.largest);
  scrubber.value = String(frame);
  const seconds = (frame / trial.params.fps).toFixed(2);
  the("place", HTMLOutputElement).value = `${seconds} s`;
  scrubber.setAttribute("aria-valuetext", `frame ${frame}, ${seconds} s, HS ${series.hs[frame].toFixed(2)}`);
  movePlayhead(frame);
}

/**
 * Draw what was computed of the chosen trial.
 * @param {Series} series
 * @param {Series | null} ghost
 */
function drawTrial(series, ghost) {
  const { t_sp, fps } = changed(trial.params, levers, changes);
  movePlayhead = drawTraces(tracesPicture, series, ghost, t_sp, fps);
  the("ghost", HTMLElement).hidden = !ghost;
  const fires = (/** @type {Series} */ { hsSpikes, vsSpikes }) =>
    `HS ${told(hsSpikes, "rightward", "leftward")}` +
    (counted(vsSpikes) ? `, VS ${told(vsSpikes, "downward", "upward")}.` : ".");
  the("count", HTMLElement).textContent = `Spikes: ${fires(series)}${ghost ? ` Unchanged: ${fires(ghost)}` : ""}`;
  showFrame();
}

/** Compute the chosen trial, and draw it; then the curve, in small parts, unless something is moved meanwhile. */
async function refresh() {
  asked = false;
  const mine = ++turn;
  const pause = async () => {
    await new Promise((resolve) => setTimeout(resolve));
    return mine === turn;
  };
  const wanted = commandOf(trial.id, texts());
  if (shown?.clip !== clip || settings !== wanted) {
    shown?.network.free();
    shown = new Run(kernel, tables, clip, changed(trial.params, levers, changes), true);
    settings = wanted;
  }
  shown.advance();
  const { series } = shown;
  if (!series.hs.length) return;
  const compares = texts().length > 0 && !taking;
  const ghost = compares
    ? (ghosts.get(clip) ?? (await new Run(kernel, tables, clip, trial.params).finish(pause)))
    : null;
  if (mine !== turn) return;
  if (ghost) ghosts.set(clip, ghost);
  if (taking) frame = clip.frames.length - 1;
  else if (frame < 0)
    frame = series.hs.reduce((best, hs, i, all) => (Math.abs(hs) > Math.abs(all[best]) ? i : best), 0);
  drawTrial(series, ghost);
  showSettings();
  if (!taking) await drawCounts(pause);
}

/**
 * Count the spikes at each speed, and judge them.
 * @param {() => Promise<boolean>} pause
 */
async function drawCounts(pause) {
  /** @type {Map<number, number>} */
  const counts = new Map();
  const rows = [];
  const params = changed(trial.params, levers, changes);
  const all = Object.fromEntries(levers.map((lever) => [lever.key, settingOf(lever, params)]));
  for (const each of curve) {
    const film = await clipOf(each);
    const of = await new Run(kernel, tables, film, changed(each.params, levers, all)).finish(pause);
    if (!of || each.speed === null) return;
    const count = counted(of.hsSpikes);
    counts.set(each.speed, count);
    const fired = of.hsSpikes.filter((spikes) => spikes !== 0).length;
    const highest = of.hs.reduce((most, value) => Math.max(most, value), 0).toFixed(2);
    rows.push(`<tr><th scope="row">${each.speed}</th><td>${count}</td><td>${fired}</td><td>${highest}</td></tr>`);
  }
  if (!(await pause())) return;
  const { word, checks } = judged(claim, counts);
  drawCurve(the("curve", SVGSVGElement), counts, new Map(curve.map((each) => [each.speed ?? 0, each.spikes])));
  const verdict = the("word", HTMLElement);
  verdict.textContent = `${word} in these trials`;
  verdict.className = word;
  the("speeds", HTMLTableSectionElement).innerHTML = rows.join("");
  the("checks", HTMLUListElement).innerHTML = checks
    .map(({ more, less, difference, passes }) => {
      const signed = difference < 0 ? `\u2212${-difference}` : `+${difference}`;
      const [kind, mark] = passes ? ["holds", "\u2713"] : ["fails", "\u2717"];
      return `<li class="${kind}">${mark} ${more} against ${less} cm/s: ${signed}</li>`;
    })
    .join("");
  document.body.dataset.busy = "false";
  performance.mark("counted");
}

/** Show the levers' values, the command, and the link. */
function showSettings() {
  const params = changed(trial.params, levers, changes);
  for (const lever of levers) {
    const row = the(`lever-${lever.key}`, HTMLElement);
    const [value, before] = [settingOf(lever, params), settingOf(lever, trial.params)];
    const input = the(`input-${lever.key}`, HTMLInputElement);
    if (lever.kind === "switch") input.checked = Boolean(value);
    else input.value = String(value);
    const unit = lever.unit ? ` ${lever.unit}` : "";
    the(`value-${lever.key}`, HTMLElement).textContent = lever.kind === "switch" ? "" : `${value}${unit}`;
    row.classList.toggle("moved", value !== before);
    const back = the(`reset-${lever.key}`, HTMLButtonElement);
    back.hidden = value === before;
    back.title = `back to ${before}`;
  }
  the("command", HTMLElement).textContent = commandOf(trial.command, texts());
  if (trial !== data.footage) history.replaceState(null, "", `#${written(trial.id, frame, levers, changes)}`);
}

/** Compute soon, once for all that is moved until then. */
function ask() {
  if (!asked) requestAnimationFrame(refresh);
  asked = true;
  document.body.dataset.busy = "true";
}

/**
 * Move to a frame.
 * @param {number} wanted
 */
function seek(wanted) {
  frame = Math.max(0, Math.min(clip.frames.length - 1, wanted));
  showFrame();
}

/**
 * Choose a trial, with its frames.
 * @param {Recorded} chosen
 * @param {Clip} film
 * @param {number} at The frame to show; -1: where HS is farthest from 0.
 */
function choose(chosen, film, at = -1) {
  [trial, clip, frame] = [chosen, film, at];
  the("trial", HTMLSelectElement).value = chosen.id;
  scrubber.max = String(Math.max(film.frames.length - 1, 0));
  const special = levers
    .filter((lever) => settingOf(lever, chosen.params) !== settingOf(lever, first.params))
    .map((lever) => `${lever.name} = ${settingOf(lever, chosen.params)}`);
  the("note", HTMLElement).textContent =
    chosen.note +
    (special.length
      ? ` With it the levers, and the curve of ${claim.id}, have the values for clips off-line: ${special.join(", ")}.`
      : "");
  say("");
  ask();
}

/** Take over what a link says. */
async function follow() {
  taking?.stop();
  const link = read(location.hash.slice(1), levers);
  const chosen = data.trials.find((each) => each.id === link.trial) ?? first;
  const film = await clipOf(chosen);
  changes = link.changes;
  choose(chosen, film, Math.min(link.frame, film.frames.length - 1));
}

/** @param {boolean} wanted */
function play(wanted) {
  const button = the("play", HTMLButtonElement);
  button.textContent = wanted ? "\u23F8" : "\u25B6";
  button.setAttribute("aria-label", wanted ? "Pause" : "Play");
  if (playing) clearInterval(playing);
  playing = wanted ? setInterval(() => seek((frame + 1) % clip.frames.length), 1000 / trial.params.fps) : 0;
  if (!wanted) showSettings();
}
/** @type {ReturnType<typeof setInterval> | 0} */
let playing = 0;

/**
 * Take frames of a camera or a file, showing each as it comes, until it is stopped; then it is a trial as any other.
 * @param {File | null} file
 */
async function take(file) {
  taking?.stop();
  play(false);
  const buttons = ["camera", "video"].map((id) => the(id, HTMLButtonElement));
  for (const each of buttons) each.disabled = true;
  const video = await opened(file)
    .catch((error) => say(`${file ? file.name : "The webcam"} cannot be opened: ${error.message ?? error}`))
    .finally(() => {
      for (const each of buttons) each.disabled = false;
    });
  if (!video) return;
  const { rows, columns } = data.footage;
  const film = { rows, columns, frames: /** @type {Uint8Array[]} */ ([]) };
  data.footage.note = `${file ? "Your video" : "Your webcam"}, at ${columns}x${rows} px. It stays in this page.`;
  data.footage.command = `colias watch ${file ? `'${file.name.replaceAll("'", "'\\''")}'` : "0"} --size ${columns}x${rows}`;
  own = film;
  the("trial", HTMLSelectElement).querySelector("option[hidden]")?.removeAttribute("hidden");
  choose(data.footage, film);
  const button = the(file ? "video" : "camera", HTMLButtonElement);
  const title = button.textContent;
  taking = taken(video, film, () => {
    button.textContent = `Stop (${film.frames.length} of ${LONGEST})`;
    scrubber.max = String(film.frames.length - 1);
    ask();
  });
  await taking.done;
  button.textContent = title;
  taking = null;
  if (film.frames.length) ask();
  else say("Nothing was seen: the video has no frame that this browser can show.");
}

/** Write the levers into the page. */
function makeLevers() {
  the("levers", HTMLElement).innerHTML = levers
    .map(({ key, name, part, kind, low, high, step, meaning, paper }) => {
      const id = `input-${key}`;
      const input =
        kind === "switch"
          ? `<input type="checkbox" role="switch" id="${id}">`
          : `<input type="range" id="${id}" min="${low}" max="${high}" step="${step}" aria-describedby="about-${key}">`;
      return (
        `<div class="lever" id="lever-${key}"><label for="${id}"><code>${name}</code>${["", ", near", ", far"][part === null ? 0 : part + 1]}</label>` +
        `<span id="value-${key}"></span>` +
        `<button type="button" id="reset-${key}" aria-label="Reset ${key}" hidden>&#8634;</button>${input}` +
        `<p id="about-${key}">${meaning}${paper && ` \u00b7\u00a0paper:\u00a0${paper}`}</p></div>`
      );
    })
    .join("");
  for (const lever of levers) {
    const input = the(`input-${lever.key}`, HTMLInputElement);
    input.addEventListener("input", () => {
      changes[lever.key] = lever.kind === "switch" ? input.checked : input.valueAsNumber;
      ask();
    });
    the(`reset-${lever.key}`, HTMLButtonElement).addEventListener("click", () => {
      delete changes[lever.key];
      input.focus();
      ask();
    });
  }
}

function begin() {
  const groups = [...new Set(data.trials.map((each) => each.group))];
  const option = (/** @type {Recorded} */ { id, title }) => `<option value="${id}">${title}</option>`;
  the("trial", HTMLSelectElement).innerHTML = `${groups
    .map((group) => {
      const inside = data.trials.filter((each) => each.group === group).map(option);
      return `<optgroup label="${group}">${inside.join("")}</optgroup>`;
    })
    .join("")}<option value="${data.footage.id}" hidden>${data.footage.title}</option>`;
  the("curve-title", HTMLElement).textContent = `${claim.id}: spikes against speed`;
  the("says", HTMLElement).textContent = claim.says;
  the("margin", HTMLElement).textContent = `${claim.margin} ${claim.margin === 1 ? "spike" : "spikes"}`;
  makeLevers();
  the("trial", HTMLSelectElement).addEventListener("change", async (event) => {
    taking?.stop();
    const id = /** @type {HTMLSelectElement} */ (event.target).value;
    const chosen = data.trials.find((each) => each.id === id);
    if (chosen) choose(chosen, await clipOf(chosen));
    else if (own) choose(data.footage, own);
  });
  scrubber.addEventListener("input", () => seek(scrubber.valueAsNumber));
  scrubber.addEventListener("change", showSettings);
  the("play", HTMLButtonElement).addEventListener("click", () => play(!playing));
  const point = (/** @type {PointerEvent} */ event) => {
    if (event.buttons) seek(frameAt(tracesPicture, event.clientX, clip.frames.length));
  };
  tracesPicture.addEventListener("pointerdown", point);
  tracesPicture.addEventListener("pointermove", point);
  the("defaults", HTMLButtonElement).addEventListener("click", () => {
    changes = {};
    ask();
  });
  the("camera", HTMLButtonElement).addEventListener("click", () => (taking ? taking.stop() : take(null)));
  const file = the("file", HTMLInputElement);
  the("video", HTMLButtonElement).addEventListener("click", () => (taking ? taking.stop() : file.click()));
  file.addEventListener("change", () => file.files?.[0] && take(file.files[0]));
  addEventListener("hashchange", () => {
    follow();
    document.querySelector(".stage")?.scrollIntoView({ block: "nearest" });
  });
  new ResizeObserver(() => shown && ask()).observe(tracesPicture);
}

begin();
await follow();
