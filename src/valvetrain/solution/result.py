"""The one result object of a run: labelled channels, events, named quantities, status, statistics,
provenance.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import FrozenMapping, InputError, NamedNumbers
from valvetrain.solution.atomic import atomic_path
from valvetrain.solution.channels import ChannelArrays, DatasetField, empty_channels
from valvetrain.solution.display import Saveable, frame, span, value_text, verdict_first
from valvetrain.solution.provenance import Provenance
from valvetrain.solution.quantity import unit_of
from valvetrain.solution.status import COMPLETED, Event, Fact, Status

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, eq=False)
class Solution(Saveable):
    """What one run computed; see docs/architecture.md for channel names.

    ``channels`` is an :class:`xarray.Dataset` whose variables all start with dimension ``sample``
    and have ``units`` and ``long_name``, with coordinates ``time`` (s) and ``cam_angle`` (rad, from
    the start of the revolution in which the samples begin, whose number is ``revolution``) along
    it; a reduced solution has none. ``cycle``: the last whole revolution alone, by cam angle. ``quantities``: named numbers (SI) by
    :func:`valvetrain.quantities.evaluate.evaluate`; ``gaps``: a sentence per part of them that
    failed. Raises :class:`InputError` when a channel breaks that rule.

    >>> from valvetrain.solution.channels import spring_channels
    >>> channels = spring_channels(time=[0.0, 0.01], cam_angle=[0.0, 2.0], values={"seat_force": [310.0, 620.0]})
    >>> solution = Solution(channels, quantities={"peak_seat_force": 620.0})
    >>> solution.channel("seat_force").max()
    np.float64(620.0)
    >>> list(solution.to_pandas().columns)
    ['cam_angle', 'seat_force']
    """

    channels: DatasetField = DatasetField()
    events: tuple[Event, ...] = ()
    status: Status = COMPLETED
    statistics: Mapping[str, float | int | str | bool] = field(default_factory=dict)
    provenance: Provenance = field(default_factory=lambda: Provenance("", ""))
    quantities: Mapping[str, float] = field(default_factory=dict)
    gaps: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "events", tuple(self.events))
        object.__setattr__(self, "quantities", NamedNumbers(self.quantities))
        object.__setattr__(self, "statistics", FrozenMapping(self.statistics))

    @property
    def arrays(self) -> ChannelArrays:
        """The channels as plain arrays, without the labels that need xarray."""
        found: ChannelArrays = self.__dict__["_arrays"]
        return found

    @property
    def model(self) -> str:
        """Name of the spring model that ran."""
        return self.provenance.model

    @property
    def label(self) -> str:
        """Name of the run within its study."""
        return self.provenance.label

    @property
    def spring_set(self) -> str:
        """Spring set of the train that ran; empty where there is one only."""
        return self.provenance.spring_set

    @property
    def facts(self) -> tuple[Fact, ...]:
        """Facts of this run: what its model leaves out, what its inputs need."""
        return self.provenance.facts

    @property
    def springs(self) -> tuple[str, ...]:
        """Names of the springs, outer first; prefixes of the channels of a nested pair
        (:meth:`channel_of`).
        """
        return self.provenance.springs

    def channel_of(self, spring: str, name: str) -> str:
        """Name of a channel of one spring: ``outer_coil_gap`` of a nested pair, ``coil_gap`` of a
        single spring.
        """
        return f"{spring}_{name}" if len(self.springs) > 1 else name

    @property
    def engine_speed(self) -> float:
        """Crank speed (rad/s)."""
        return self.provenance.engine_speed

    @property
    def cam_angle(self) -> Array:
        """Cam angle (rad, unwrapped) of every sample."""
        return np.asarray(self.arrays.coords["cam_angle"].values)

    @property
    def time(self) -> Array:
        """Time (s) of every sample."""
        return np.asarray(self.arrays.coords["time"].values)

    def has(self, *names: str) -> bool:
        """True when every named channel was computed."""
        return all(name in self.arrays.variables for name in names)

    def channel(self, name: str) -> Array:
        """Values of one channel, first axis ``sample``, SI; :class:`InputError` names those that
        exist.
        """
        if name not in self.arrays.variables:
            known = ", ".join(self.arrays.variables)
            raise InputError(
                f"this {self.model or 'unnamed'} run has no channel '{name}'; "
                f"{f'it has {known}' if known else 'it is reduced to its numbers, so run it whole'}"
            )
        return np.asarray(self.arrays.variables[name].values)

    @property
    def cycle(self) -> xarray.Dataset:
        """All channels over the last whole cam revolution, or the unfinished one where none is
        whole.

        Dimension ``cam_angle`` (rad, from 0 to less than 2 pi), then ``coil_number`` or
        ``upper_coil``, ascending, each with unit and label; ``time`` (s) along the first, and
        ``revolution``, which one it is.
        """
        return self.arrays.cycle

    def __getitem__(self, name: str) -> xarray.DataArray:
        """A channel of :attr:`cycle`: ``run["seat_force"].plot()``,
        ``run["valve_lift"].sel(cam_angle=np.pi, method="nearest")``; ``name`` as for
        :meth:`channel`.
        """
        self.channel(name)
        return self.arrays.only([name]).cycle[name]

    def unit(self, name: str) -> str:
        """Unit (SI) of one channel; ``name`` as for :meth:`channel`."""
        self.channel(name)
        return str(self.arrays.variables[name].attrs["units"])

    def identical(self, other: Solution) -> bool:
        """True when every value, label, attribute and event of ``other`` is the same."""
        fields = ("events", "status", "statistics", "provenance", "quantities", "gaps")
        return all(getattr(self, name) == getattr(other, name) for name in fields) and bool(
            self.channels.identical(other.channels)
        )

    def with_found(
        self,
        events: Iterable[Event],
        quantities: Mapping[str, float],
        gaps: Iterable[str] | None = None,
    ) -> Solution:
        """A copy with events, named quantities and ``gaps`` (None: those there are)."""
        named = self.gaps if gaps is None else tuple(gaps)
        return replace(
            self, channels=self.arrays, events=tuple(events), quantities=quantities, gaps=named
        )

    def with_facts(self, facts: tuple[Fact, ...]) -> Solution:
        """A copy with other facts."""
        provenance = replace(self.provenance, facts=facts)
        return replace(self, channels=self.arrays, provenance=provenance)

    def reduced(self) -> Solution:
        """The same run without its channels: events, quantities, status, statistics and provenance
        stay.
        """
        return replace(self, channels=empty_channels())

    def __repr__(self) -> str:
        lines = [self._head()]
        if len(self.time):
            angle = span(self.cam_angle, "rad").replace("deg", "deg of the cam")
            lines.append(
                f"{len(self.time)} samples, {angle}; {len(self.arrays.variables)} channels"
            )
        for name in [
            one for one in ("seat_force", "retainer_force", "valve_lift") if self.has(one)
        ][:2]:
            lines.append(f"{name} {span(self.channel(name), self.unit(name))}")
        if self.events:
            kinds = Counter(event.kind for event in self.events)
            lines.append(f"events: {', '.join(f'{count} {kind}' for kind, count in kinds.items())}")
        if self.quantities:
            named = [
                f"{name} {value_text(value, unit_of(name))}"
                for name, value in list(self.quantities.items())[:3]
            ]
            lines.append(
                f"quantities ({len(self.quantities)}): {', '.join(named)}{', ...' if len(self.quantities) > 3 else ''}"
            )
        if self.gaps:
            lines.append(f"{len(self.gaps)} not found: {self.gaps[0]}")
        return verdict_first(self, lines)

    def _head(self) -> str:
        speed = f", {value_text(self.engine_speed, 'rad/s')}" if self.engine_speed else ""
        return f"Solution of {self.provenance.case_name or 'a case'}, {self.label or 'unnamed model'}{speed}: {self.status.sentence()}"

    def to_pandas(self) -> pandas.DataFrame:
        """Channels (SI) by time (s) as a frame, a channel over wire points or coil pairs one column
        each: ``coil_gap[3.5]``.

        ``attrs["units"]`` holds the units. A reduced solution gives no rows; its numbers are in
        ``quantities``.
        """
        columns: dict[str, Array] = {"time": self.time, "cam_angle": self.cam_angle}
        units = {"time": "s", "cam_angle": "rad"}
        for label, channel in self.arrays.variables.items():
            values, coils = (
                np.asarray(channel.values).reshape(len(self.time), -1),
                self.arrays.along(label),
            )
            places = coils if coils is not None else np.arange(values.shape[1])
            names = (
                [f"{label}[{place:g}]" for place in places] if len(channel.dims) > 1 else [label]
            )
            columns |= dict(zip(names, values.T, strict=True))
            units |= dict.fromkeys(names, channel.attrs["units"])
        return frame(columns, "time", units)

    def cite(self) -> tuple[str, ...]:
        """References behind this run, the papers to cite with it."""
        return self.provenance.citations


def save_csv(solution: Solution, path: str | os.PathLike[str]) -> Path:
    """Write the channels of a solution as one wide table of text; whole or not at all.

    Channels with a second dimension take one column per wire point or coil pair, named with its
    coil number. The NetCDF file (:func:`save_netcdf`) is the one that is read back.

    Parameters
    ----------
    solution : one run
    path : file to write; its folder is made if absent

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : a path that cannot be written

    Examples
    --------
    >>> import valvetrain as vt
    >>> (run,) = vt.simulate("job-t", "2000 rpm", models=["massless"]).solutions
    >>> path = vt.solution.save_csv(run, "run.csv")
    >>> path.read_text().splitlines()[0].split(",")[0]
    'time [s]'
    """
    arrays = solution.arrays
    header, blocks = list[str](), list[Array]()
    for name, one in (*arrays.coords.items(), *arrays.variables.items()):
        if one.dims[:1] != ("sample",):
            continue
        block = one.values.reshape(len(one.values), int(np.prod(one.values.shape[1:])))
        blocks.append(block)
        unit = one.attrs.get("units", "1")
        if len(one.dims) == 1:
            header.append(f"{name} [{unit}]")
            continue
        along, dimension = arrays.along(name), one.dims[1].replace("_", " ")
        places = np.arange(block.shape[1]) if along is None else along
        header += [f"{name} at {dimension} {place:.6g} [{unit}]" for place in places]
    with (
        atomic_path(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(f"{','.join(header)}\n")
        for row in range(len(solution.time)):
            # the list writes its numbers as ``repr`` does, faster than one by one
            cells = repr([value for block in blocks for value in block[row].tolist()])[1:-1]
            stream.write(f"{cells.replace(', ', ',')}\n")
    return Path(path)
