"""Why the robot may have seen what the bench's model of its eye does not: the map over what nobody knows of it.

What follows was committed before any of it was run. Figures of a few runs at seeds 0 to 3 had been seen (without C32
but for the default camera, where straight recession fired in 1 of 20 trials of replicate 0, and up to 10 of 10 under
other cameras); so the seeds here begin at 1000.

**Design.** The paper's experiments with the robot, with its own wheels' poses under feedback, at every combination of

- gamma: off; on, metered before the curve; on and metered behind it (presets ``ov7670``, ``ov7670-gamma``,
  ``ov7670-gamma-metered``);
- network steps a second: 30, 15, 10, 7.5, as a processor gives that takes every frame, every second one, and so on;
- floor: 0.81, as the arena's, and 0.1, a black screen;
- low-pass: recursive, and two taps in FDSR, as in the first author's public code.

20 replicates in the three corners that README quotes (gamma off at 30 steps, gamma at 15, gamma metered at 15, all with
a floor of 0.81 and recursive), 5 in the others, where only k of 5 is reported.

**Judged.** C13 to C20, C29, C31 and C32, and C15 of leftward crossings by C15's own judge, which is no claim of the
paper. All bounds are those of ``claims.toml``; C32 asks for 90 % of at least 10 trials of each motion, pooled over a
replicate's experiments. A silent model is not judged by C13 and C32. Cells share frames and seeds, so they are compared
in pairs, by McNemar's exact test; not judged counts as not held.

**The primary questions**, each answered by the rule of words over the 20 replicates of its corner: with gamma on,
metered before the curve, at 15 steps a second, floor 0.81, recursive low-pass, does the network keep

1. C15 (the count peaks near 6 cm/s),
2. C16 (the count falls with distance),
3. C32 (straight motion in depth is silent in nine tenths of the trials)?

All other cells, claims and comparisons are exploration.
"""
