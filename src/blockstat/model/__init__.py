"""From a scene to blocks."""

from blockstat.model.build import build

__all__ = ["build"]
