"""A cross vault on four piers: how wide must they be?"""

from blockstat import Assembly, assess
from blockstat.model import assemble, groin_vault, moved, pier

SPAN, HEIGHT = 4.0, 3.0
CORNERS = {"ne": (1, 1), "nw": (-1, 1), "sw": (-1, -1), "se": (1, -1)}


def on_piers(width: float) -> Assembly:
    """The vault with piers that grow outwards from the corners of its clear span; width [m]."""
    blocks = groin_vault(spans=(SPAN, SPAN), thickness=0.4, voussoirs=15, brick=0.7)
    place = (SPAN + width) / 2
    for corner, (x, y) in CORNERS.items():
        stones = pier(size=(width, width), height=HEIGHT, courses=6, plinth=0.3)
        blocks += moved(stones, (x * place, y * place, -HEIGHT), prefix=f"{corner}.")
    return assemble(blocks, supports=[f"{corner}.plinth" for corner in CORNERS], name=f"piers of {width:g} m")


def main() -> None:
    for width in (0.5, 0.8, 1.1, 1.4):
        verdict = assess(on_piers(width))
        print(f"{verdict.assembly.name}: {verdict.interfaces.n_interfaces} interfaces, {verdict.outcome.word}")


if __name__ == "__main__":
    main()
