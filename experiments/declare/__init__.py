"""What users write: experiments, clips, behaviours, claims, studies."""
