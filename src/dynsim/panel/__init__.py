"""What dynamics add to the live page: "Let it fall" and "Optimise".

This room imports `judge`, `comparison`, and of `blockstat` the root, `analysis`, `design_search`, `view` and `app`.
"""

from dynsim.panel.fall import FallPanel
from dynsim.panel.optimise import OptimisePanel

__all__ = ["FallPanel", "OptimisePanel"]
