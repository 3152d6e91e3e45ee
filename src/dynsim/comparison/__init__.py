"""Static and dynamic verdicts side by side, and why they differ.

This room imports `judge`, `parallel` and `blockstat.analysis.assess`.
"""
