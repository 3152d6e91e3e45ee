"""Search of the designs of a scene, with a history on disk.

This room imports `analysis`, `chance`, `sensitivity`, `imperfection`, `spec`, `contact`, `system` and the root. A
dynamic verifier is handed in as a function.
"""
