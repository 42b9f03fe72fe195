"""Off-line experiments: clips of stimuli shown to models."""
