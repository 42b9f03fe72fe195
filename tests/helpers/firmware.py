"""Which tests need the tools of the chip."""

import shutil

import pytest

from experiments.robot import firmware

TOOLS = {firmware.GCC: "gcc-arm-none-eabi", firmware.QEMU: "qemu-system-arm"}


MISSING = [package for program, package in TOOLS.items() if shutil.which(program) is None]


needs_tools = pytest.mark.skipif(bool(MISSING), reason=f"needs {' and '.join(MISSING)}: tools/setup.sh --firmware")
