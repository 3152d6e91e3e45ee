"""Search of the designs of a scene, with a history on disk.

This room imports `analysis`, `sensitivity`, `spec` and `model`. A dynamic verifier is handed in as a function.
"""
