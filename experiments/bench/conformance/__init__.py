"""The laws that every vision model keeps, tried on one model."""
