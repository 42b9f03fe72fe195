"""What the robot's chip would compute: its program built, measured and checked in an emulator, and exported."""
