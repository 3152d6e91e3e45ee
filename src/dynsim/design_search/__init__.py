"""The design search with Bullet as its verifier, and the buttress loop of the paper.

This room imports `judge`, `parallel`, `comparison` and `blockstat.design_search`.
"""
