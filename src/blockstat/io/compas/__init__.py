"""Files of COMPAS: assemblies, models and problems in JSON, in and out.

This room imports `io`, `system` and the root.
"""
