"""Registers of the OV7670 for a picture's tone: their values after a reset, and their meaning.

The values after a reset are from two public lists of the OV7670's registers: a table for an FPGA and an annotated
driver (mikrocontroller.net, attachment 391403). They agree with each other and with the exposure registers of the data
sheet, whose page on tone was not available. The inputs of the gamma curve are from the data sheet of the sibling OV7675
(version 2.0, section 5.5), which has the same registers. The sign of BRIGHT follows the Linux driver of the OV7670.
"""

from __future__ import annotations

GAMMA_INPUTS = (4, 8, 16, 32, 40, 48, 56, 64, 72, 80, 96, 112, 144, 176, 208)
"""Inputs at which the segments of the gamma curve end, in grey levels."""
GAMMA_RESET = (0x04, 0x07, 0x10, 0x28, 0x36, 0x44, 0x52, 0x60, 0x6C, 0x78, 0x8C, 0x9E, 0xBB, 0xD2, 0xE5)
"""GAM1 to GAM15, 0x7B to 0x89, after a reset: the outputs at these inputs."""
GAMMA_VENDOR = (0x10, 0x1E, 0x35, 0x5A, 0x69, 0x76, 0x80, 0x88, 0x8F, 0x96, 0xA3, 0xAF, 0xC4, 0xD7, 0xE8)
"""GAM1 to GAM15 in the vendor's recommended settings, from the Linux driver of the OV7670."""
UNIT_CONTRAS = 0x40
"""CONTRAS, 0x56, after a reset: a contrast of 1."""
CONTRAS_CENTER_RESET = 0x80
"""CONTRAS_CENTER, 0x57, after a reset: the grey that contrast does not change."""
