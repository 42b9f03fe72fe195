"""Maps: in how many replicates each claim holds, at every point of a grid of parameters."""
