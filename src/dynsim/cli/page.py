"""The command `dynsim app`: the live page with Bullet."""

from __future__ import annotations

from blockstat.cli.options import PORT, FileArgument, Port, Supports


def open_page(file: FileArgument, supports: Supports = None, port: Port = PORT) -> None:
    """Open the live page with Bullet: "Let it fall" and "Optimise" beside the static verdict."""
    from blockstat.app.server import serve
    from dynsim.panel import FallPanel, OptimisePanel

    serve(file, supports=supports or "", port=port, panels=[FallPanel(), OptimisePanel()])
