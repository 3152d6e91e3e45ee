"""The command `dynsim app`: the live page with Bullet."""

from __future__ import annotations

from blockstat.cli.options import PORT, FileArgument, Folder, Gap, MostGigabytes, MostSeconds, Port, Supports, Units, Up


def open_page(
    file: FileArgument,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    port: Port = PORT,
    folder: Folder = None,
    most_seconds: MostSeconds = 300.0,
    most_gigabytes: MostGigabytes = 4.0,
) -> None:
    """Open the live page with Bullet: "Let it fall" and "Optimise" beside the static verdict."""
    from blockstat.app.background import Limits
    from blockstat.app.capacity_tab.panel import CapacityPanel
    from blockstat.app.server import serve
    from dynsim.panel import FallPanel, OptimisePanel

    limits, panels = Limits(most_seconds, most_gigabytes), [CapacityPanel(), FallPanel(), OptimisePanel()]
    read = {"supports": supports or "", "units": units, "up": up, "gap": gap}
    serve(file, **read, port=port, panels=panels, folder=folder, limits=limits)
