"""Where every figure of the README and the docs comes from: benchmarks, comparisons, references, and their pages.

Run from the root of the project: `python -m evidence` does the jobs, `python -m evidence.benchmarks.sweep` one script.
The package is no part of what is installed. It may import `blockstat` and `dynsim`; neither imports it.
"""
