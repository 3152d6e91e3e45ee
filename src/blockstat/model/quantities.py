"""Types of the options of builders, with the bounds that scene files are held to."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Length = Annotated[float, msgspec.Meta(gt=0)]
Size = Annotated[float, msgspec.Meta(ge=0)]
Number = Annotated[int, msgspec.Meta(ge=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
Two = Annotated[int, msgspec.Meta(ge=2)]  #: or more
Three = Annotated[int, msgspec.Meta(ge=3)]  #: or more
Ends = tuple[float, float]
Point = tuple[float, float, float]
Lengths = tuple[Length, Length]

Bond = Literal["running", "stack"]
Groins = Literal["solid", "mitred"]
Edge = Literal["south", "north", "west", "east"]
