"""Three-dimensional views of assemblies and verdicts, drawn with viser."""
