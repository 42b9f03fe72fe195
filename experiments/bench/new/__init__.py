"""Files to begin with: what ``colias new`` writes for each kind of file of one's own."""
