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
  const value = params[lever.name];
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
  const result = structuredClone(params);
  for (const lever of levers) {
    if (!(lever.key in changes)) continue;
    if (lever.part === null) result[lever.name] = changes[lever.key];
    else result[lever.name][lever.part] = changes[lever.key];
  }
  return result;
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
  return [...new Set(moved)].map((name) => `${name}=${after[name]}`);
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
 * Read a link's part after "#"; values that a lever cannot take are left out.
 * @param {string} text
 * @param {Lever[]} levers
 * @returns {{trial: string | null, frame: number, changes: Changes}} The frame is -1 where none is given.
 */
export function read(text, levers) {
  const given = new URLSearchParams(text);
  /** @type {Changes} */
  const changes = {};
  for (const { key, kind, low, high, step } of levers) {
    const value = given.get(key);
    const number = Number(value || Number.NaN);
    if (kind === "switch") {
      if (value === "true" || value === "false") changes[key] = value === "true";
    } else if (number >= low && number <= high && (step !== 1 || Number.isInteger(number))) changes[key] = number;
  }
  const frame = Number(given.get("frame") || -1);
  return { trial: given.get("trial"), frame: Number.isInteger(frame) ? frame : -1, changes };
}
