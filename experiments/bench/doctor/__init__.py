"""What ``colias doctor`` finds out about a machine."""
