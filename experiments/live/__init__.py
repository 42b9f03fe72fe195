"""A page on which one drives the stimulus by hand and watches the network: ``colias live``."""
