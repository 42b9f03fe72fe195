"""Write the C header with the network's parameters, to compile ``onboard.c`` for the robot."""

from __future__ import annotations

from collections.abc import Iterable

from dsnn.onboard.fixed import FixedPoint, constants
from dsnn.onboard.params import OnboardParams

TABLES = {
    "residues": "int16_t", "kernel_e": "int16_t", "kernel_i": "int16_t", "alphas": "int32_t", "decode": "uint16_t",
    "decay": "uint8_t", "sigmoid": "int16_t", "thresholds": "int16_t",
}  # fmt: skip
"""Field of `dsnn.onboard.fixed.FixedPoint` that is a table -> the type of its entries."""
IN_RAM = ("decode", "decay")
"""Lookup tables for 8-bit D, read twice a frame for each D. D of 16 bits needs none."""
_DERIVED = ("state_bytes",)


def header(shape: tuple[int, int], params: OnboardParams) -> str:
    """Make the text of ``onboard_config.h``.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    params
        The parameters of the on-board network.

    Returns
    -------
    str
        The header's text. It has a macro ``ONBOARD_NAME`` for each whole number of `dsnn.onboard.fixed.FixedPoint`, and
        ``ONBOARD_STATE_BYTES`` for the memory of a model. Each table is ``static const``, and ``onboard_fixed`` is the
        configuration of all, for ``onboard.c``. If D has 8 bits, the tables `IN_RAM` have the attribute
        ``ONBOARD_IN_RAM``. It is empty unless you define it, for example as a section of the RAM.

    Raises
    ------
    dsnn.frames.FrameError
        The shape is invalid or too large.
    """
    fixed = constants(shape, params)
    names = [name for name in FixedPoint.__slots__ if name not in TABLES]
    lines = [
        "/* Constants of the on-board network, written by colias-sim. Set were:",
        *(f" * {name} = {getattr(params, name)!r}" for name in params.__dataclass_fields__),
        " */",
        "#ifndef ONBOARD_CONFIG_H",
        "#define ONBOARD_CONFIG_H",
        "",
        '#include "onboard.h"',
        "",
        *(f"#define ONBOARD_{name.upper()} {_number(getattr(fixed, name))}" for name in (*names, *_DERIVED)),
        "",
        "#ifdef ONBOARD_WITH_TABLES /* by onboard.c alone: other files need the macros, not a copy of the tables */",
        "#ifndef ONBOARD_IN_RAM",
        "#define ONBOARD_IN_RAM",
        "#endif",
    ]
    for name, kind in TABLES.items():
        place = "ONBOARD_IN_RAM " if name in IN_RAM and fixed.state_bits == 8 else ""
        lines += _table(f"{place}static const {kind} onboard_{name}[]", getattr(fixed, name))
    fields = [*(f".{name} = ONBOARD_{name.upper()}" for name in names), *(f".{t} = onboard_{t}" for t in TABLES)]
    lines += [
        "static const onboard_config onboard_fixed = {",
        *(f"    {field}," for field in fields),
        "};",
        "#endif",
        "",
    ]
    return "\n".join([*lines, "#endif", ""])


def _number(value: int) -> str:
    return str(value) if value < 2**31 else f"INT64_C({value})"


def _table(declared: str, values: Iterable[int]) -> list[str]:
    """Write a table, eight entries a line. An empty one has a 0, because C has no empty arrays."""
    entries = [str(value) for value in values] or ["0"]
    rows = [", ".join(entries[i : i + 8]) for i in range(0, len(entries), 8)]
    return [f"{declared} = {{", *(f"    {row}," for row in rows), "};"]
