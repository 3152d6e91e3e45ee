"""Beyond the first motion: load multiplier against displacement, with a bracket at each step.

The rooms below it, from the ground up: `displaced` says where blocks and contact points are, `overlap` where joints
touch that have slid, `statics` does limit analysis there, `linkage` follows a mechanism exactly, and `finite_steps`
follows what is no linkage.

The words of these rooms:

- pose: the finite rotation and displacement of every block.
- contact pair: a contact point as two material points, one on each block; its gap is their distance along the normal.
- active set: the contacts that are closed. Of these some stick and some slide in a motion; the others open.
- linkage: rigid bodies that sticking and sliding contacts hold together, with one degree of freedom.
- parameter: the displacement of the control, or the movement of the supports [m].
- event: a change of the active set. At a jump the structure moves at constant parameter.
- limit state: the limit multiplier at a pose, its mechanism and its forces.
- implicit step: a finite step as one convex program, in which contacts slide, open and close.
- associated flow: a joint that slides opens by friction times slip. Non-associated flow ("coulomb"): it does not open.

This room imports `analysis`, `certificate`, `contact`, `geometry`, `linear_algebra`, `loading`, `program`,
`solve` and the root.
"""
