"""Mutation testing: small bugs put into the source one at a time, and whether a test notices (`make mutants`).

The mutations are those of Cosmic Ray (https://cosmic-ray.readthedocs.io); mutmut was weighed, too. It runs its mutants
inside a copy of the project in which every function is a trampoline, which the tests of the source itself do not pass,
and it knows no sample. Of Cosmic Ray only the operators are used: each mutant has a test command of its own here, the
tests that reach its line, the fastest first.
"""
