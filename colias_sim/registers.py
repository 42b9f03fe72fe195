"""Registers of the OV7670 that shape a picture's tone: what they hold after a reset, and what their numbers mean.

Sources: the values after a reset as two public lists of the OV7670's registers have them, a table for an FPGA and an
annotated driver (mikrocontroller.net, attachment 391403). They agree with each other and with the exposure registers of
the data sheet; its page was not read. The inputs of the gamma curve are
of the data sheet of the sibling OV7675 (version 2.0, section 5.5), which has the same registers. The sign of BRIGHT is
that of the Linux driver of the OV7670.
"""

from __future__ import annotations

GAMMA_INPUTS = (4, 8, 16, 32, 40, 48, 56, 64, 72, 80, 96, 112, 144, 176, 208)
"""Inputs at which the segments of the gamma curve end, in grey levels."""
GAMMA_RESET = (0x04, 0x07, 0x10, 0x28, 0x36, 0x44, 0x52, 0x60, 0x6C, 0x78, 0x8C, 0x9E, 0xBB, 0xD2, 0xE5)
"""GAM1 to GAM15, 0x7B to 0x89, after a reset: the outputs there."""
GAMMA_VENDOR = (0x10, 0x1E, 0x35, 0x5A, 0x69, 0x76, 0x80, 0x88, 0x8F, 0x96, 0xA3, 0xAF, 0xC4, 0xD7, 0xE8)
"""GAM1 to GAM15 in the settings that the vendor hands out, as the Linux driver of the OV7670 has them."""
UNIT_CONTRAS = 0x40
"""CONTRAS, 0x56, after a reset: a contrast of 1."""
CONTRAS_CENTER_RESET = 0x80
"""CONTRAS_CENTER, 0x57, after a reset: the grey that contrast leaves as it is."""
