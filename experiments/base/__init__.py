"""What everything stands on: errors, the console, files, random streams, users' files."""
