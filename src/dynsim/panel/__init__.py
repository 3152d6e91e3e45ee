"""What dynamics add to the live page: "Let it fall" and "Optimise".

This room imports `judge`, `comparison`, `blockstat.app` and `blockstat.design_search`.
"""

from dynsim.panel.fall import FallPanel
from dynsim.panel.optimise import OptimisePanel

__all__ = ["FallPanel", "OptimisePanel"]
