"""Models of direction: the DSNN and its family, arrays of elementary motion detectors, optical flow."""
