"""Behaviours in an env, played and scored."""
