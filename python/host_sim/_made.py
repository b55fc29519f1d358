"""When and by which call a result was made: what its page says of itself."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any, NamedTuple, ParamSpec, TypeVar

from ._machine import Machine
from ._recordings import Recording

if TYPE_CHECKING:
    from ._results import _Paged

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result", bound="_Paged")


class Made(NamedTuple):
    """When and by which call."""

    written: str
    """Date, time and zone: ``2026-05-06 07:08 +02:00``."""
    call: str


def tells_its_making(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A command whose result knows when and by which call it was made."""

    @functools.wraps(function)
    def called(*given: Arguments.args, **named: Arguments.kwargs) -> Result:
        result = function(*given, **named)
        result._made = Made(_now(), _call(function.__name__, given, named))
        return result

    return called


def _now() -> str:
    """The time, or that of SOURCE_DATE_EPOCH, as the program says it."""
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    try:
        at = datetime.fromtimestamp(int(given), timezone.utc)
    except (ValueError, OverflowError, OSError):
        at = datetime.now().astimezone()
    zone = f"{at:%z}"
    return f"{at:%Y-%m-%d %H:%M} {zone[:3]}:{zone[3:5]}"


def _call(name: str, given: tuple[Any, ...], named: Mapping[str, Any]) -> str:
    """The call as it may be typed again, as far as a text can say it: what is in memory stands in angle brackets."""
    arguments = [_text(value) for value in given] + [f"{key}={_text(value)}" for key, value in named.items()]
    return f"host_sim.{name}({', '.join(arguments)})"


def _text(value: Any) -> str:
    if isinstance(value, os.PathLike):
        return repr(os.fspath(value))
    if value is None or isinstance(value, (str, bool, int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)) and all(not isinstance(one, (int, float)) for one in value):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, Machine):
        return f"<machine {value.path}>"
    if isinstance(value, Recording):
        return f"<recording {value.name}>"
    return f"<{type(value).__name__}>"
