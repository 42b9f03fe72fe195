"""Settings: what ``--set`` and ``--model`` mean."""
