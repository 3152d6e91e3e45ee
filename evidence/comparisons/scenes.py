"""The scenes of the long comparison: references whose limit is known, and random small buildings."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from blockstat import Assembly, InputError
from evidence.references.dynamics import LIMITS
from evidence.scenes.families import Random, arch, chapel, hut, portal, wall
from evidence.scenes.small import SCENES

SEED = 13
#: Multiples of the known limit: the first three stand.
FACTORS = (0.8, 0.9, 0.97, 1.03, 1.1, 1.25)
#: Random families: maker, share of the scenes, direction of the push that brings them down, those with a push first.
RANDOM: dict[str, tuple[Callable[[Random], Assembly], float, tuple[int, int, int]]] = {
    "arch": (arch, 0.26, (1, 0, 0)), "portal": (portal, 0.19, (1, 0, 0)), "wall": (wall, 0.19, (1, 0, 0)),
    "hut": (hut, 0.17, (0, 1, 0)), "chapel": (chapel, 0.19, (0, 1, 0)),
}  # fmt: skip
MOST_BLOCKS = 80


@dataclass(frozen=True)
class Scene:
    """An assembly whose name begins with its family; stands : what is known of it."""

    family: str
    assembly: Assembly
    stands: bool | None = None
    push: tuple[int, int, int] | None = None

    @property
    def name(self) -> str:
        return self.assembly.name


def references() -> Iterator[Scene]:
    """Scenes on both sides of known limits, and small ones of the tests."""
    for reference in LIMITS:
        for factor in FACTORS:
            name = f"{reference.name} at {factor:g} of its limit"
            yield Scene("reference", reference.scene(factor).with_(name=name), factor < 1)
    for name, make, options in SCENES:
        if np.isfinite(options.get("friction", 0.7)):
            yield Scene("reference", make().with_(name=name, **options))


def randoms(number: int) -> Iterator[Scene]:
    """About that many random scenes of at most `MOST_BLOCKS` blocks."""
    for k, (family, (make, share, push)) in enumerate(RANDOM.items()):
        found, seed = 0, 0
        while found < round(share * number):
            seed += 1
            try:
                assembly = make(np.random.default_rng([SEED, k, seed]))
            except InputError:
                continue
            if assembly.n_blocks <= MOST_BLOCKS:
                found += 1
                yield Scene(family, assembly.with_(name=f"{family} {seed}"), push=push)
