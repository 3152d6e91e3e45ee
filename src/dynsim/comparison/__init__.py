"""Static and dynamic verdicts side by side, and why they differ.

This room imports the root, `engine`, `judge`, `parallel`, and of `blockstat` the root, `contact`, `analysis`,
`sequence` and `system`.
"""
