"""Made-up studies whose runs differ in every channel and number, so that no number can stand for
another.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synthetic_study import own_study, published_study, sweep_study, train_study
from valvetrain.solution.study import Study


def numbered(study: Study) -> Study:
    """The study with every run's channels and numbers raised by a share of its own, and with
    energies that tell from each other.
    """
    runs = []
    for place, run in enumerate(study.solutions, start=1):
        share = 1 + place / 50
        raised = {
            name: (values.dims, share * values.values, values.attrs)
            for name, values in run.channels.data_vars.items()
        }
        channels = run.channels.assign(raised)
        if "kinetic_energy" in channels:
            work = channels["work_done"]
            channels = channels.assign(
                kinetic_energy=work.copy(data=0.11 * np.abs(work.values)),
                contact_energy=work.copy(data=0.03 * np.abs(work.values)),
                energy_dissipated=work.copy(data=np.linspace(0.2, 0.5, work.size) * share),
            )
        found = {
            name: value if name.endswith(("order", "count", "frequency")) else value * share
            for name, value in run.quantities.items()
        }
        runs.append(replace(run, channels=channels, quantities=found))
    return replace(study, solutions=tuple(runs))


STUDIES = {
    "own": lambda: numbered(own_study()), "published": lambda: numbered(published_study()), "train": lambda: numbered(train_study()),
    "sweep": lambda: numbered(sweep_study()),
}  # fmt: skip
