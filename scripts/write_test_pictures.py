"""Writes the pictures of docs/model-against-test.md from the sample tests: ``python
scripts/write_test_pictures.py``.
"""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path

from valvetrain.compare_test.compare import compare_with_test
from valvetrain.compare_test.page import difference_chart, values_chart
from valvetrain.compare_test.summary import unit_of_test
from valvetrain.measured.sensor import Sensor
from valvetrain.report.run_charts import looks
from valvetrain.report.svg_chart import svg
from valvetrain.solution.atomic import write_text

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"


def main() -> None:
    """Write both pictures."""
    with tempfile.TemporaryDirectory() as folder:
        samples = Path(folder)
        runpy.run_path(str(ROOT / "scripts" / "sample_test_cycles.py"))["main"](samples)
        models = ["finite-element", "multi-mass"]
        force = compare_with_test(
            "job-t",
            samples / "spring-force.csv",
            spring_models=models,
            sensor=Sensor(bandwidth="8 kHz"),
        )
        unit, factor = unit_of_test(force)
        write_text(
            PICTURES / "model-less-test.svg",
            svg(difference_chart(force, force.runs, unit, factor, looks(force.study))),
        )
        head = compare_with_test("gu2021-beehive", samples / "engine-head.csv")
        write_text(PICTURES / "engine-head.svg", svg(values_chart(head, looks(head.study))))


if __name__ == "__main__":
    main()
