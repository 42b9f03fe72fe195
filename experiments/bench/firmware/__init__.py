"""Firmware of the robot's chip: its program built, measured and checked in an emulator, and exported."""
