"""From a scene or from parameters to blocks."""

from blockstat.model.arch import arch, jack_arch
from blockstat.model.build import build
from blockstat.model.placing import assemble, moved

__all__ = ["arch", "assemble", "build", "jack_arch", "moved"]
