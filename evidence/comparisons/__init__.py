"""Static against dynamic verdicts on random and given assemblies: how often they agree, and why they do not."""
