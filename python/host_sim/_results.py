"""Results, typed: each is a view of the JSON that the program writes, which ``to_dict()`` returns."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Optional

from ._machine import Machine
from ._made import Made
from ._recordings import Recording
from ._tables import Table

if TYPE_CHECKING:
    import numpy
    import pandas
    import polars

    from . import _native

Verdict = Literal["missing-physics", "nothing-missing", "unexplained"]

__all__ = [
    "Comparison",
    "Diagnosis",
    "Finding",
    "Fit",
    "Inspection",
    "Parameter",
    "Plan",
    "SignalFit",
    "Simulation",
    "Table",
]


@dataclass(frozen=True)
class Parameter:
    """An estimated parameter."""

    name: str
    value: float
    """In ``unit``, SI."""
    std: Optional[float]
    """Its standard deviation in ``unit``; None where the recordings do not determine it."""
    unit: str
    before: Optional[float] = None
    """The value it started from, in ``unit``."""
    size: Optional[str] = None
    """What the value means at this drive: "0.83 l/min at 70 bar across the piston"."""

    @classmethod
    def _of(cls, told: dict[str, Any]) -> Parameter:
        return cls(
            name=told["name"],
            value=told["value"],
            std=told["std"],
            unit=told["unit"],
            before=told.get("before"),
            size=told.get("size"),
        )


@dataclass(frozen=True)
class Finding:
    """An effect that the model lacks, or that has changed."""

    effect: str
    claimed: str
    """What is claimed, as a sentence."""
    subsystem: str
    """The link of the drive: valve, flow, chambers, mechanics or sensing."""
    confidence: float
    """0 to 1."""
    parameters: tuple[Parameter, ...]
    alternatives: tuple[tuple[str, float], ...]
    """Effects that might be taken for it, each with its confidence, 0 to 1."""
    separated_by: str
    """The test that would separate it from the most probable alternative."""
    raw: dict[str, Any] = field(repr=False)
    """All that the JSON says of it."""

    @classmethod
    def _of(cls, told: dict[str, Any]) -> Finding:
        return cls(
            effect=told["effect"],
            claimed=told["claimed"],
            subsystem=told["subsystem"],
            confidence=told["confidence"],
            parameters=tuple(Parameter._of(one) for one in told["parameters"]),
            alternatives=tuple((one["effect"], one["confidence"]) for one in told["alternatives"]),
            separated_by=told["separated_by"],
            raw=told,
        )


@dataclass(frozen=True)
class SignalFit:
    """How well one signal of one section of the model follows one recording."""

    recording: str
    section: str
    signal: str
    nrmse_percent: float
    """100·(1 − ‖y − ŷ‖/‖y − mean y‖) %: 100 is perfect, 0 no better than the mean."""
    r_squared: float
    rmse: float
    """In ``unit``, SI."""
    max_error: float
    """In ``unit``, SI."""
    max_at_s: float
    """Time of the largest error, s."""
    over_noise: float
    """The RMSE over the recorded signal's noise; about 1 for a perfect model."""
    unit: str


class _Result:
    """A result with the JSON that the program writes for it."""

    _json: str

    def __init__(self, text: str) -> None:
        self._json = text
        self._told: dict[str, Any] = json.loads(text)

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the program writes, as Python's values: a new copy each time."""
        told: dict[str, Any] = json.loads(self._json)
        return told

    def to_json(self) -> str:
        """The JSON that the program writes, on one line."""
        return self._json


class _Paged(_Result):
    """A result with the page that the program writes for it."""

    _page: _native.Page
    _made: Optional[Made] = None
    """When and by which call it was made; what a command returns has it."""

    def to_html(self) -> str:
        """The report's page: self-contained, it loads nothing."""
        return self._page.html(*(self._made or (None, None)))

    def save_report(self, path: str | os.PathLike[str]) -> None:
        """Writes the page: what the program writes with ``--report``."""
        Path(path).write_text(self.to_html(), encoding="utf-8")

    def _repr_html_(self) -> str:
        page = html.escape(self.to_html(), quote=True)
        title = type(self).__name__
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 50em; border: 0" title="{title}"></iframe>'


def _drawings(*svg: str) -> str:
    return "".join(f'<div style="max-width: 60em; background: white">{one}</div>' for one in svg)


def _text(text: str) -> str:
    return f"<pre>{html.escape(text)}</pre>"


class Diagnosis(_Paged):
    """What a model lacks: where, which physics, and how much better it follows with it.

    In a notebook it is the report's page with its charts, in a frame of its own.
    """

    def __init__(self, native: _native.Diagnosed) -> None:
        super().__init__(native.json())
        self._inner = native
        self._page = native.page()

    @property
    def verdict(self) -> Verdict:
        """``missing-physics``, ``nothing-missing`` or ``unexplained``."""
        verdict: Verdict = self._told["verdict"]
        return verdict

    @property
    def findings(self) -> list[Finding]:
        """What is claimed, the most certain first; empty where nothing is."""
        return [Finding._of(finding) for finding in self._told["findings"]]

    @property
    def located(self) -> dict[str, Any]:
        """Where the misfit is: ``subsystem``, ``signal``, ``share``, ``intervals``, ``region`` …; empty where there is none."""
        located: dict[str, Any] = self._told["located"]
        return located

    @property
    def parameters(self) -> list[Parameter]:
        """The refitted base parameters, SI."""
        return [Parameter._of(parameter) for parameter in self._told["parameters"]]

    @property
    def confirmed(self) -> Optional[bool]:
        """Whether held-out recordings confirm what was found; None without a test on them."""
        confirmed: Optional[bool] = self._told["confirmed"]
        return confirmed

    @property
    def fit(self) -> dict[str, dict[str, dict[str, float]]]:
        """NRMSE fit of every signal in %: ``fit["holdout"]["before" | "after" | "noise_floor"]["position"]``; or ``"train"``."""
        fit: dict[str, dict[str, dict[str, float]]] = self._told["fit"]
        return fit

    @property
    def is_finished(self) -> bool:
        """Whether the search came to its own end, and not to that of ``time_limit_s``."""
        return self._told["unfinished"] is None

    @property
    def notes(self) -> list[str]:
        """What was noticed in the recordings, each with a recording's name."""
        return self._inner.notes

    @property
    def machine(self) -> Machine:
        """The machine with refitted parameters and the effects found: what ``--save-machine`` writes."""
        return Machine._of(self._inner.machine())

    @property
    def recordings(self) -> list[str]:
        """The names of the recordings, those of training first."""
        return self._inner.recordings()

    def trajectories(self, recording: int | str = 0) -> Table:
        """Every judged signal of a recording, SI: recorded, before (refitted parameters alone) and after (with what was found).

        The headers are ``time [s]`` and then ``position recorded [m]``, ``position before [m]``, ``position after [m]`` ….
        """
        names = self.recordings
        index = names.index(recording) if isinstance(recording, str) and recording in names else recording
        table = self._inner.trajectories(index) if isinstance(index, int) and 0 <= index < len(names) else None
        if table is None:
            raise KeyError(f"{recording!r} is no recording of this diagnosis; expected one of {names}, or its index")
        return Table(table)

    def __str__(self) -> str:
        return self._inner.text()

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict}, findings={[finding.effect for finding in self.findings]})"


class Comparison(_Paged):
    """The fit of every measured signal, end to end and link by link. In a notebook it is its page."""

    def __init__(self, native: tuple[str, list[str], list[str], list[_native.Table], _native.Page]) -> None:
        text, self.notes, self._svg, self._tables, self._page = native
        super().__init__(text)

    @property
    def fits(self) -> list[SignalFit]:
        """One for each recording, section and signal."""
        return [
            SignalFit(recording=recording["recording"], section=section["section"], **signal)
            for recording in self._told["recordings"]
            for section in recording["sections"]
            for signal in section["signals"]
        ]

    @property
    def weakest(self) -> Optional[dict[str, Any]]:
        """The weakest part over all recordings: ``section``, ``signal``, ``nrmse_percent`` (mean), and whether it ``follows``."""
        weakest: Optional[dict[str, Any]] = self._told["weakest"]
        return weakest

    @property
    def drawings(self) -> list[str]:
        """A drawing of each recording as SVG: every signal recorded and simulated end to end."""
        return self._svg

    def trajectories(self, recording: int = 0) -> Table:
        """A recording simulated end to end, in its own columns and units, as ``simulate`` writes it in double precision."""
        return Table(self._tables[recording])

    def to_pandas(self) -> pandas.DataFrame:
        """The fits as a pandas DataFrame."""
        import dataclasses

        import pandas

        return pandas.DataFrame([dataclasses.asdict(fit) for fit in self.fits])

    def __repr__(self) -> str:
        weakest = self.weakest
        told = f"weakest: {weakest['section']}, {weakest['signal']} at {weakest['nrmse_percent']} %" if weakest else ""
        return f"Comparison({len(self._told['recordings'])} recordings; {told})"


class Fit(_Paged):
    """A refit of the base parameters. In a notebook it is its page."""

    def __init__(self, native: tuple[str, _native.Machine, list[str], str, _native.Page]) -> None:
        text, machine, self.notes, self._table, self._page = native
        super().__init__(text)
        self.machine = Machine._of(machine)
        """The machine with the fitted values: what ``--save-machine`` writes."""

    @property
    def parameters(self) -> list[Parameter]:
        """The fitted values, SI."""
        return [Parameter._of(parameter) for parameter in self._told["parameters"]]

    @property
    def converged(self) -> bool:
        """Whether the search came to rest."""
        return bool(self._told["converged"])

    @property
    def left(self) -> dict[str, Any]:
        """What is left of the error: a ``sentence``, the ``signals`` with their RMSE over noise, and whether it ``is_above_noise``."""
        left: dict[str, Any] = self._told["left"]
        return left

    @property
    def is_worse(self) -> Optional[bool]:
        """Whether the fitted values are worse than the machine file's on the held-out recordings; None where none was held out."""
        held_out: Optional[dict[str, Any]] = self._told["held_out"]
        return None if held_out is None else bool(held_out["is_worse"])

    def __str__(self) -> str:
        worse = f"{self._told['held_out']['sentence']}\n" if self.is_worse else ""
        return f"{worse}{self._table}\nWhat is left: {self.left['sentence']}."

    def __repr__(self) -> str:
        return f"Fit({len(self.parameters)} parameters, converged={self.converged})"


class Simulation:
    """The signals of the model for a recording or an input signal."""

    def __init__(self, native: _native.Simulated) -> None:
        self._inner = native
        self.table = Table(native.table)
        """What the program writes with ``--out``: the columns and units of the recording, or SI units for an input signal."""

    @property
    def notes(self) -> list[str]:
        """What to know of it, each with the recording's name."""
        return self._inner.notes

    @property
    def tick_ms(self) -> float:
        """The step of the model, ms."""
        return self._inner.tick_ms

    def to_dict(self) -> dict[str, list[Optional[float]]]:
        """The columns of the file that the program writes, number by number."""
        return self.table.to_dict()

    def to_pandas(self) -> pandas.DataFrame:
        """The signals as a pandas DataFrame."""
        return self.table.to_pandas()

    def to_polars(self) -> polars.DataFrame:
        """The signals as a polars DataFrame, without a copy."""
        return self.table.to_polars()

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> Any:
        return self.table.__arrow_c_stream__(requested_schema)

    def __getitem__(self, header: str) -> numpy.ndarray:
        """The values under a header, in its unit."""
        return self.table[header]

    def __repr__(self) -> str:
        return f"Simulation({', '.join(self.table.headers)})"

    def _repr_html_(self) -> str:
        return _drawings(self._inner.drawing) if self._inner.drawing else _text(repr(self))


class Inspection(_Paged):
    """What recordings hold, which links of a drive they can test, and what is missing to test the others. In a notebook it is its page."""

    def __init__(self, native: tuple[str, str, _native.Page]) -> None:
        text, self._said, self._page = native
        super().__init__(text)

    @property
    def recordings(self) -> list[dict[str, Any]]:
        """One for each recording."""
        recordings: list[dict[str, Any]] = self._told["recordings"]
        return recordings

    def __str__(self) -> str:
        return self._said

    def __repr__(self) -> str:
        return f"Inspection({len(self.recordings)} recordings)"


class Plan(_Result):
    """Before recording: which effects could be seen and told apart, and how to excite the drive."""

    def __init__(self, native: tuple[str, _native.Recording, str, str]) -> None:
        text, excitation, self._svg, self._said = native
        super().__init__(text)
        self.excitation = Recording._of(excitation)
        """The excitation that separates most: time in s, command in V, and the load in N where there is one."""

    @property
    def tests(self) -> list[str]:
        """The standard tests that it is made of."""
        tests: list[str] = self._told["best"]["tests"]
        return tests

    @property
    def claimed(self) -> list[str]:
        """The effects that would be claimed, were they as strong as they usually are."""
        return [effect["effect"] for effect in self._told["best"]["outlook"]["effects"] if effect["claimed"]]

    def __str__(self) -> str:
        return self._said

    def __repr__(self) -> str:
        return f"Plan({', '.join(self.tests)}; {len(self.claimed)} effects would be claimed)"

    def _repr_html_(self) -> str:
        return _drawings(self._svg)
