"""Arithmetic in scene files: strings that begin with "=" and speak of the scene's parameters."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from blockstat.errors import InputError

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs, "ceil": math.ceil, "cos": math.cos, "floor": math.floor, "max": max, "min": min, "round": round,
    "sin": math.sin, "sqrt": math.sqrt, "tan": math.tan,
}  # fmt: skip
CONSTANTS = {"pi": math.pi}
RESERVED = (*FUNCTIONS, *CONSTANTS)
_SIGNS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
    ast.UAdd: operator.pos, ast.USub: operator.neg,
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}  # fmt: skip
LONGEST = 500  #: characters of an expression


def is_expression(node: Any) -> bool:
    """Whether a value of a scene is to be computed.

    Parameters
    ----------
    node : object
        A value of a scene.

    Returns
    -------
    bool
        True for a text that begins with "=".
    """
    return isinstance(node, str) and node.lstrip().startswith("=")


def evaluate(text: str, value_of: Callable[[str], float], names: Mapping[str, Any]) -> float:
    """The number that an expression stands for; a comparison is 1 or 0.

    Parameters
    ----------
    text : str
        Arithmetic that begins with "="; angles are in radians.
    value_of : callable
        Gives the number of a parameter.
    names : mapping
        The parameters there are.

    Returns
    -------
    float
        A finite number.

    Raises
    ------
    InputError
        Saying which word or sign is wrong.

    Examples
    --------
    >>> evaluate("= 2 * t + max(1, 3)", {"t": 0.5}.__getitem__, {"t": 0.5})
    4.0
    """
    body = text.strip()[1:].strip()
    try:
        if len(body) > LONGEST:
            raise SyntaxError
        tree = ast.parse(body, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise InputError(f'"{text[:80]}" is no arithmetic such as "= 2 * t + 1"') from None
    try:
        # Before the expression is computed, so that one in another takes little of the stack.
        values = {name: float(value_of(name)) for name in _words(tree) if name in names and name not in CONSTANTS}
        value = _Arithmetic(values, names).visit(tree)
    except _Refused as refusal:
        raise InputError(f'"{text}": {refusal}') from None
    except RecursionError:
        raise InputError(f'"{text[:80]}" is too deep; take it apart into several parameters') from None
    except OverflowError:
        raise InputError(f'"{text}" is too large a number') from None
    except (ArithmeticError, TypeError) as error:
        raise InputError(f'"{text}": {error}') from None
    if isinstance(value, complex) or not math.isfinite(value):
        raise InputError(f'"{text}" is {value}; it must be a finite number')
    return value


def _words(tree: ast.AST) -> list[str]:
    """Names in an expression, each once, in their order."""
    return list(dict.fromkeys(node.id for node in ast.walk(tree) if isinstance(node, ast.Name)))


class _Refused(Exception):
    """A word or a sign that is no arithmetic."""


class _Arithmetic(ast.NodeVisitor):
    """Computes an expression; anything without a method of its own is refused."""

    def __init__(self, values: Mapping[str, float], names: Mapping[str, Any]) -> None:
        self.values, self.names = values, names

    def visit_Constant(self, node: ast.Constant) -> float:
        if isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
            return float(node.value)
        return self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> float:
        if node.id in CONSTANTS:
            return CONSTANTS[node.id]
        if node.id not in self.names:
            known = ", ".join(self.names) or "none"
            raise _Refused(f'no parameter "{node.id}"; parameters are: {known}')
        return self.values[node.id]

    def visit_BinOp(self, node: ast.BinOp) -> float:
        return self._sign(node, node.op)(self.visit(node.left), self.visit(node.right))

    def visit_UnaryOp(self, node: ast.UnaryOp) -> float:
        return self._sign(node, node.op)(self.visit(node.operand))

    def visit_Compare(self, node: ast.Compare) -> float:
        if len(node.ops) > 1:
            return self.generic_visit(node)
        return float(self._sign(node, node.ops[0])(self.visit(node.left), self.visit(node.comparators[0])))

    def visit_Call(self, node: ast.Call) -> float:
        if not isinstance(node.func, ast.Name) or node.keywords:
            return self.generic_visit(node)
        if node.func.id not in FUNCTIONS:
            raise _Refused(f'no function "{node.func.id}"; functions are: {", ".join(FUNCTIONS)}')
        arguments = [self.visit(argument) for argument in node.args]
        try:
            return float(FUNCTIONS[node.func.id](*arguments))
        except ValueError as error:
            raise _Refused(f"{ast.unparse(node)}: {error}") from None

    def generic_visit(self, node: ast.AST) -> float:
        raise _Refused(f'"{ast.unparse(node)}" is not allowed; it must be arithmetic over the parameters')

    def _sign(self, node: ast.AST, sign: ast.AST) -> Callable[..., Any]:
        return _SIGNS.get(type(sign)) or self.generic_visit(node)  # type: ignore[return-value]
