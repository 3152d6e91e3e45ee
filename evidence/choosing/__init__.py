"""How exact, for how long: error against seconds of each number that a user may choose.

A module takes one such number (the tolerance of a limit load, the steps of a capacity curve, the resolution of a run of
Bullet, the draws of a Monte Carlo), and `page` puts their tables and curves on one page.
"""
