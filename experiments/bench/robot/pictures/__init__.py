"""Pictures that the observer sees in a trial: eyes, and the pictures that a recording shows."""
