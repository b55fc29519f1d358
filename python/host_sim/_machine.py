"""A drive, as its machine file describes it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from . import _native


class Described(NamedTuple):
    """What a parameter of a machine is."""

    unit: str
    """Its unit, SI."""
    meaning: str
    least: float
    """The least value that it may have."""
    most: float
    """The largest value that it may have."""


class Machine:
    """A drive: the parameters of a machine file (TOML, SI units, the unit in the key).

    ``machine["cylinder.stroke_m"]`` is a value, ``machine.replaced({"cylinder.stroke_m": 0.5})`` the drive with another one. It
    cannot be changed in place.
    """

    _inner: _native.Machine

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Reads a machine file.

        Raises:
            Error: what is wrong, with ``file``, ``row`` (the line, from 1) and ``key``.
        """
        self._inner = _native.Machine.read(path)

    @classmethod
    def _of(cls, native: _native.Machine) -> Machine:
        machine = cls.__new__(cls)
        machine._inner = native
        return machine

    @classmethod
    def from_toml(cls, text: str, name: str = "machine.toml") -> Machine:
        """A machine from the text of a machine file; ``name`` stands for the file in messages."""
        return cls._of(_native.Machine.from_toml(text, name))

    @property
    def name(self) -> str:
        """The name of the drive."""
        return self._inner.name

    @property
    def path(self) -> str:
        """The machine file as it was named."""
        return self._inner.path

    @property
    def source(self) -> str:
        """What moves the drive: ``valve``, ``pump`` or ``force``."""
        return self._inner.source

    @property
    def effects(self) -> list[str]:
        """The effects that are switched on."""
        return self._inner.effects

    def keys(self) -> list[str]:
        """The keys of the parameters that the file gives."""
        return self._inner.keys()

    def __getitem__(self, key: str) -> float:
        """The value of a parameter in the unit that its key ends with (:meth:`describe`)."""
        return self._inner[key]

    def to_dict(self) -> dict[str, float]:
        """The parameters that the file gives, SI."""
        return {key: self[key] for key in self.keys()}

    @staticmethod
    def describe(key: str) -> Described:
        """Unit, meaning, and range of a parameter."""
        return Described(*_native.Machine.describe(key))

    def replaced(self, values: Mapping[str, float]) -> Machine:
        """This drive with other values, SI, checked as those of a file; an effect whose value is given is switched on."""
        return Machine._of(self._inner.replaced([(key, float(value)) for key, value in values.items()]))

    def to_toml(self) -> str:
        """The text of the machine file: that which was read, with its comments, and with changed values in it."""
        return self._inner.to_toml()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the machine file, whole or not at all."""
        self._inner.save(path)

    def __repr__(self) -> str:
        return f"Machine({self.name!r}, {self.source}, effects={self.effects})"
