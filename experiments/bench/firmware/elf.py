"""Sizes of the sections of an ELF file (Tool Interface Standard, Executable and Linking Format 1.2), 32 bits."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path

_ALLOCATED = 0x2
"""Flag of a section that takes memory of the chip: SHF_ALLOC."""


def sections(path: Path) -> Mapping[str, int]:
    """Name -> bytes of every section that takes memory of the chip; ``ValueError`` for a file that is no such ELF."""
    data = path.read_bytes()
    if data[:6] != b"\x7fELF\x01\x01":
        raise ValueError(f"{path} is no 32-bit little-endian ELF file")
    table, size, number, names = struct.unpack_from("<I10xHHH", data, 32)
    rows = [struct.unpack_from("<10I", data, table + size * i) for i in range(number)]
    text = rows[names][4]
    sizes: dict[str, int] = {}
    for name, _, flags, _, _, length, *_ in rows:
        if flags & _ALLOCATED and length:
            start = text + name
            sizes[data[start : data.index(b"\0", start)].decode()] = length
    return sizes
