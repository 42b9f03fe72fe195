"""Studies: claims and measures counted at every point of a grid, for every model, in whole replicates."""
