// The word on C15, by the pairs of speeds and the bound that Python's judge has.

/**
 * @typedef {object} Claim
 * @property {string} id
 * @property {string} says
 * @property {[number, number][]} pairs Speeds, cm/s: more spikes are asked for at the first than at the second.
 * @property {number} margin By so many, or more.
 *
 * @typedef {{more: number, less: number, difference: number, passes: boolean}} Check
 */

/**
 * Count spikes, whatever their sign.
 * @param {number[]} spikes
 */
export const counted = (spikes) => spikes.reduce((sum, count) => sum + Math.abs(count), 0);

/**
 * Tell how many spikes there are, and of which direction.
 * @param {number[]} spikes
 * @param {string} plus What a positive spike tells.
 * @param {string} minus
 */
export function told(spikes, plus, minus) {
  const total = counted(spikes);
  const positive = counted(spikes.filter((count) => count > 0));
  if (positive && positive < total) return `${total} (${positive} ${plus}, ${total - positive} ${minus})`;
  return total ? `${total} ${positive ? plus : minus}` : "0";
}

/**
 * Judge counts of spikes.
 * @param {Claim} claim
 * @param {Map<number, number>} counts Speed -> count.
 * @returns {{word: "holds" | "fails", checks: Check[]}}
 */
export function judged(claim, counts) {
  const checks = claim.pairs.map(([more, less]) => {
    const difference = (counts.get(more) ?? Number.NaN) - (counts.get(less) ?? Number.NaN);
    return { more, less, difference, passes: difference >= claim.margin };
  });
  return { word: checks.every((check) => check.passes) ? "holds" : "fails", checks };
}
