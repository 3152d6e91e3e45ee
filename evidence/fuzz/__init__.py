"""Random scenes, an independent judge of whether each stands, and what the statics make of them."""
