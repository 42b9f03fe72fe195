"""What is for the real robot: its logs, its camera, and the program of its chip."""
