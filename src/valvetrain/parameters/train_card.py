"""What the card of a cam tells the train too, so that a case says it once: lash and rocker ratio."""

from __future__ import annotations

from typing import Any

from valvetrain.parameters.schema_lift import LiftModel
from valvetrain.parameters.schema_types import problem
from valvetrain.parameters.train_schema import TrainModel


def with_cam_card(train: TrainModel, law: LiftModel | None) -> TrainModel:
    """``train`` with the ``lash`` and ``rocker_ratio`` of its lift law where it tells none; refuses
    others with the law's own place.
    """
    changes: dict[str, Any] = {}
    lash, ratio = getattr(law, "lash", None), getattr(law, "rocker_ratio", None)
    if lash is not None:
        if "lash" not in train.model_fields_set:
            changes["lash"] = lash
        elif abs(train.lash - lash) > 1e-6:
            raise problem(
                f"lash is {lash * 1e3:.4g} mm here and {train.lash * 1e3:.4g} mm in [train]; correct one, or leave it out of [train]",
                ("lift_law", "lash"),
            )
    lever = train.lever
    if ratio is not None and lever is not None:
        if lever.ratio is None and lever.valve_arm is None:
            changes["lever"] = lever.model_copy(update={"ratio": ratio})
        else:
            own = (
                lever.ratio
                if lever.ratio is not None
                else (lever.valve_arm or 0.0) / lever.drive_arm
            )
            if abs(own / ratio - 1) > 0.02:
                raise problem(
                    f"rocker_ratio is {ratio:g} here, but the lever's arms make {own:.4g}; correct one, or leave valve_arm out",
                    ("lift_law", "rocker_ratio"),
                )
    return train.model_copy(update=changes) if changes else train
