"""Runs the jobs: two at a time, with a stamp that says which source the figures of each come from.

`sources` finds what a job depends on, `stamps` keeps its hash and commit, `runner` runs each on one thread (`threads`),
and `quick` makes pages with fewer scenes.
"""
