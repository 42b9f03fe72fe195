"""Write the C source of the extension module ``_dsnn_native``, for the build.

cffi runs in API mode: the compiler checks the declarations against the headers that they are read from.
"""

from __future__ import annotations

import hashlib
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
HEADERS = ("dsnn.h", "onboard.h")
"""Headers of the functions that Python calls; they include no other header of ours."""
ONBOARD = (
    "onboard.c", "onboard.h", "onboard_target.h", "onboard_arithmetic.h", "onboard_state.h", "onboard_retina.h",
    "onboard_lamina.h", "onboard_adaptation.h", "onboard_correlation.h", "onboard_plate.h",
)  # fmt: skip
"""Sources of the on-board network, which the robot's firmware shares."""
SOURCES = (
    "dsnn.c", "dsnn.h", "lgmd1.c", "passes.c", "exponential.c", "models.h", "lanes.h", "memory.h", *ONBOARD,
)  # fmt: skip
"""All sources of the extension module."""


def digest() -> str:
    """Compute the SHA-256 of the C sources in this folder, which identifies a build."""
    whole = hashlib.sha256()
    for name in SOURCES:
        whole.update((HERE / name).read_bytes())
    return whole.hexdigest()


def declarations() -> str:
    """Read the declarations of `HEADERS` for cffi: without comments and preprocessor lines."""
    whole = "\n".join((HERE / name).read_text(encoding="utf-8") for name in HEADERS)
    text = re.sub(r"/\*.*?\*/", "", whole, flags=re.DOTALL)
    return "\n".join(line for line in text.splitlines() if not line.startswith("#"))


def write(path: str) -> None:
    """Write the module's C source to ``path``."""
    from cffi import FFI

    builder = FFI()
    builder.cdef(declarations() + "\nextern const char *const vision_source;\n")
    builder.set_source(
        "_dsnn_native",
        "".join(f'#include "{name}"\n' for name in HEADERS)
        + f'static const char *const vision_source = "{digest()}";\n',
    )
    builder.emit_c_code(path)


if __name__ == "__main__":
    write(sys.argv[1])
