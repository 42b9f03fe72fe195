"""Sources of frames: what models are shown, and what is true of it."""
