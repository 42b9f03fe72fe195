"""What the robot's true eye and wheels do to the claims."""
