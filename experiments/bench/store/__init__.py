"""The files of a run: what they hold, and what computed them."""
