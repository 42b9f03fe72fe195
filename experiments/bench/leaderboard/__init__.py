"""All models on the same trials and clips."""
