// What the levers are set to, as a link has it, and as the command line takes it.

/**
 * @typedef {import("#network").Params} Params
 *
 * @typedef {object} Lever A parameter that the page moves.
 * @property {string} key Its name; of an entry of a tuple with its place: "tau_s.0".
 * @property {string} name
 * @property {number | null} part
 * @property {"number" | "switch"} kind
 * @property {number} low
 * @property {number} high
 * @property {number} step
 * @property {string} unit
 * @property {string} meaning
 * @property {string} paper What the paper gives; empty where it gives nothing.
 *
 * @typedef {Record<string, number | boolean>} Changes Lever -> its value, where that was moved.
 */

/**
 * Look a lever's value up.
 * @param {Lever} lever
 * @param {Params} params
 * @returns {number | boolean}
 */
export function settingOf(lever, params) {
  const value = /** @type {Record<string, any>} */ (params)[lever.name];
  return lever.part === null ? value : value[lever.part];
}

/**
 * Apply changes to the params of a trial.
 * @param {Params} params
 * @param {Lever[]} levers
 * @param {Changes} changes
 * @returns {Params}
 */
export function changed(params, levers, changes) {
  const result = /** @type {Record<string, any>} */ (structuredClone(params));
  for (const lever of levers) {
    if (!(lever.key in changes)) continue;
    if (lever.part === null) result[lever.name] = changes[lever.key];
    else result[lever.name][lever.part] = changes[lever.key];
  }
  return /** @type {Params} */ (/** @type {unknown} */ (result));
}

/**
 * Write what differs from a trial's own params, as after --set: name -> value.
 * @param {Params} params
 * @param {Lever[]} levers
 * @param {Changes} changes
 */
export function assignments(params, levers, changes) {
  const after = changed(params, levers, changes);
  const moved = levers
    .filter((lever) => settingOf(lever, params) !== settingOf(lever, after))
    .map((lever) => lever.name);
  return [...new Set(moved)].map((name) => `${name}=${/** @type {Record<string, any>} */ (after)[name]}`);
}

/**
 * Write the command that does the same.
 * @param {string} command
 * @param {string[]} texts
 */
export const commandOf = (command, texts) => [command, ...texts.map((text) => `--set dsnn.${text}`)].join(" ");

/**
 * Write a link's part after "#".
 * @param {string} trial
 * @param {number} frame
 * @param {Lever[]} levers
 * @param {Changes} changes
 */
export function written(trial, frame, levers, changes) {
  const moved = levers.filter((lever) => lever.key in changes).map((lever) => [lever.key, String(changes[lever.key])]);
  return new URLSearchParams([["trial", trial], ["frame", String(frame)], ...moved]).toString();
}

/**
 * Read a link's part after "#".
 * @param {string} text
 * @param {string[]} trials Legal names.
 * @param {Lever[]} levers
 * @returns {{trial: string, frame: number | null, changes: Changes, refused: string[]}} What is not legal is in
 *   `refused`, each with the legal range.
 */
export function read(text, trials, levers) {
  const given = new URLSearchParams(text);
  /** @type {Changes} */
  const changes = {};
  /** @type {string[]} */
  const refused = [];
  let [trial, frame] = ["", /** @type {number | null} */ (null)];
  for (const [key, value] of given) {
    const lever = levers.find((candidate) => candidate.key === key);
    const number = value.trim() === "" ? Number.NaN : Number(value);
    if (key === "trial" && trials.includes(value)) trial = value;
    else if (key === "trial") refused.push(`trial=${value}: legal is ${trials.join(", ")}`);
    else if (key === "frame" && Number.isInteger(number) && number >= 0) frame = number;
    else if (key === "frame") refused.push(`frame=${value}: legal is a whole number from 0`);
    else if (!lever) refused.push(`${key}: legal is trial, frame, ${levers.map((each) => each.key).join(", ")}`);
    else if (lever.kind === "switch" && ["true", "false"].includes(value)) changes[key] = value === "true";
    else if (lever.kind === "switch") refused.push(`${key}=${value}: legal is true or false`);
    else if (number >= lever.low && number <= lever.high && (lever.step !== 1 || Number.isInteger(number)))
      changes[key] = number;
    else
      refused.push(
        `${key}=${value}: legal is ${lever.step === 1 ? "a whole number " : ""}from ${lever.low} to ${lever.high}`,
      );
  }
  return { trial, frame, changes, refused };
}
