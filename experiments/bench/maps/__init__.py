"""Maps: claims and measures at every point of a grid of parameters, in whole replicates."""
