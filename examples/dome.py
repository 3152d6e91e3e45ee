"""A dome with an oculus, thick and thin: does it stand?"""

from blockstat import assess
from blockstat.model import assemble, dome


def main() -> None:
    for bond in ("running", "stack"):
        for thickness in (0.06, 0.15):
            blocks = dome(
                span=5.0, thickness=thickness, rings=9, voussoirs=32, oculus=1.0, bond=bond, springers=0.4
            )  # fmt: skip
            verdict = assess(assemble(blocks))
            print(
                f"{bond} bond, {thickness:.2f} m: {verdict.assembly.n_blocks} blocks, "
                f"{verdict.interfaces.n_interfaces} interfaces, {verdict.outcome.word}"
            )


if __name__ == "__main__":
    main()
