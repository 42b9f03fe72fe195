"""Which of the claims about the robot survive the arithmetic of its own processor."""
