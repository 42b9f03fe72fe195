"""The real robot: its logs, its camera, the program of its chip."""
