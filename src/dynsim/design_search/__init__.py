"""The design search with Bullet as its verifier, and the buttress loop of the paper.

This room imports the root, `engine`, `judge`, `parallel`, `comparison`, and of `blockstat` the root, `contact`,
`imperfection`, `spec`, `analysis`, `design_search`, `view` and `system`.
"""
