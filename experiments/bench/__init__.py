"""The machinery that experiments share: trials, recordings, tables, statistics, figures and the command line."""
