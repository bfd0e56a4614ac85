"""How a job stands, in words."""

from __future__ import annotations

from typing import Any

from valvetrain.workbench.jobs import JobStatus

_TITLES = {"run": "Run", "compare": "Comparison of models", "sweep": "Sweep", "study": "Study", "static": "Static curve", "modes": "Modes"}
_TONES = {"finished": "good", "failed": "bad", "cancelled": "warn", "interrupted": "warn"}


def left_words(seconds: float | None) -> str:
    """Words on the time left; empty while nothing can be said."""
    if seconds is None:
        return ""
    return f"about {max(seconds, 1):.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


def job_shown(job: JobStatus | None) -> dict[str, Any] | None:
    """A job for its panel; None for none."""
    if job is None:
        return None
    going = not job.ended
    parts = (f"{100 * job.share:.0f} %", job.text, left_words(job.seconds_left)) if going and job.state == "running" else (job.text,)
    words = ", ".join(part for part in parts if part) if going else job.error
    if job.state == "cancelled" and not words:
        words = "Cancelled. What was finished is kept." if job.run_id else "Cancelled before anything was finished."
    if job.state == "queued":
        words = words or "Waits for the job before it."
    return {
        "id": job.job_id, "title": _TITLES.get(job.kind, job.kind), "state": job.state, "tone": _TONES.get(job.state, ""), "going": going,
        "percent": round(100 * job.share), "words": words, "again": job.state in ("failed", "cancelled", "interrupted"),
    }  # fmt: skip
