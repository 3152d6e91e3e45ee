"""What an answer costs: seconds of statics, solvers against each other, the live page, a sweep and a search.

A module takes its scenes from `evidence.scenes` and prints or writes a table."""
