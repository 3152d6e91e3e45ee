"""Builders of the assemblies that tests and evidence share: small ones, sized ones, random ones.

They import nothing of the rest but `evidence.paths`."""
