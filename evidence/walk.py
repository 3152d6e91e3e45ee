"""What runs between a scene and its verdict, and what the packages hand out: as JSON, for `evidence.structure`.

python -m evidence.walk CHECKOUT

Runs on whatever `blockstat` and `dynsim` the path of Python finds.
"""

from __future__ import annotations

import enum
import inspect
import json
import re
import sys
from pathlib import Path
from types import FrameType
from typing import Any

#: The head of this section of a numpy docstring.
PARAMETERS = re.compile(r"^\s*(Other )?Parameters\n\s*-{3,}\s*$", re.MULTILINE)
PACKAGES = ("blockstat", "dynsim")
SCENE = "examples/chapel.toml"


class Walk:
    """A profiler that notes files whose functions run, and types of the packages as they are first constructed.

    What runs while a module is imported is left out: an import inside a function is no step of the walk.
    """

    def __init__(self, source: Path) -> None:
        self.source = f"{source.resolve()}/"
        self.files: dict[str, None] = {}
        self.types: dict[str, None] = {}
        self.importing: list[FrameType] = []

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        if event not in ("call", "return"):
            return
        code = frame.f_code
        if self.importing:
            if event == "return" and frame is self.importing[-1]:
                self.importing.pop()
            return
        if code.co_name == "<module>":
            if event == "call":
                self.importing.append(frame)
            return
        if event == "call" and code.co_filename.startswith(self.source):
            self.files.setdefault(code.co_filename.removeprefix(self.source))
        if code.co_name in ("__init__", "__new__") and code.co_argcount:
            self._constructed(frame.f_locals.get(code.co_varnames[0]), event)

    def _constructed(self, first: object, event: str) -> None:
        kind = first if isinstance(first, type) else type(first)
        if event == "call":
            self._note(kind)
        elif kind is not first:
            for value in getattr(first, "__dict__", {}).values():
                if isinstance(value, enum.Enum):
                    self._note(type(value))

    def _note(self, kind: type) -> None:
        if kind.__module__.split(".")[0] in PACKAGES:
            self.types.setdefault(f"{kind.__module__}.{kind.__qualname__}")


def walked(root: Path) -> dict[str, list[str]]:
    """Files entered from the scene's file to the verdict, and types constructed on the way, in order."""
    import blockstat

    source = Path(blockstat.__file__).parents[1]
    walk, judged = Walk(source), Walk(source)
    sys.setprofile(walk)
    try:
        assembly = blockstat.build(blockstat.load_scene(root / SCENE))
        sys.setprofile(judged)
        blockstat.assess(assembly)
    finally:
        sys.setprofile(None)
    return {
        "files": sorted({*walk.files, *judged.files}),
        "assess_files": sorted(judged.files),
        "types": list(judged.types),
    }


def public() -> dict[str, list[str]]:
    """Names that `__all__` of the packages exports with their methods, and which lack docstring or sections."""
    found: dict[str, list[str]] = {
        key: [] for key in ("functions", "classes", "methods", "no_docstring", "no_parameters")
    }
    seen: set[int] = set()
    for package in PACKAGES:
        module = __import__(package)
        things = {name: getattr(module, name) for name in sorted(module.__all__)}
        for name in sorted(
            things, key=lambda name, things=things: len(getattr(things[name], "__mro__", ()))
        ):  # bases come first
            thing, label = things[name], f"{package}.{name}"
            if inspect.isclass(thing):
                found["classes"].append(label)
                _judge(found, label, thing, asks=False)
                for own, member in _methods(thing):
                    if id(member) in seen:  # inherited, and counted with the class before
                        continue
                    seen.add(id(member))
                    found["methods"].append(f"{label}.{own}")
                    _judge(found, f"{label}.{own}", member, asks=not isinstance(member, property))
            elif callable(thing):
                found["functions"].append(label)
                _judge(found, label, thing, asks=True)
    return found


def _methods(kind: type) -> list[tuple[str, Any]]:
    """Methods and properties without a leading underscore that the class or a base in the packages defines."""
    own: dict[str, Any] = {}
    for base in reversed(kind.__mro__):
        if base.__module__.split(".")[0] in PACKAGES:
            own |= {name: value for name, value in vars(base).items() if not name.startswith("_")}
    return [
        (name, value) for name, value in own.items()
        if inspect.isfunction(value) or isinstance(value, (classmethod, staticmethod, property))
    ]  # fmt: skip


def _judge(found: dict[str, list[str]], label: str, thing: Any, asks: bool) -> None:
    doc = inspect.getdoc(thing) or ""
    if not doc or doc.startswith(
        f"{getattr(thing, '__name__', '')}("
    ):  # a dataclass without one is given its signature
        found["no_docstring"].append(label)
    if asks and _arguments(thing) and not PARAMETERS.search(doc):
        found["no_parameters"].append(label)


def _arguments(thing: Any) -> int:
    """How many arguments a function takes beside the instance."""
    function = thing.__func__ if isinstance(thing, (classmethod, staticmethod)) else thing
    bound = not isinstance(thing, staticmethod) and "." in function.__qualname__
    return len(inspect.signature(function).parameters) - bound


if __name__ == "__main__":
    print(json.dumps({"walk": walked(Path(sys.argv[1])), "public": public()}))
