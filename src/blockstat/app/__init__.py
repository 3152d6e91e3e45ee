"""The live page: a building, its parameters as sliders, and the verdict that follows them."""
