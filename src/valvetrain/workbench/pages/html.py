"""Words of the pages: sizes, refusals, and how a job stands."""

from __future__ import annotations

from typing import Any

from valvetrain.errors import InputError, ValvetrainError
from valvetrain.runs.cost import duration_text
from valvetrain.workbench.jobs import JobStatus


def size_text(count: int) -> str:
    """A number of bytes in words.

    >>> size_text(812), size_text(20_480), size_text(3_200_000)
    ('812 bytes', '20 kB', '3.2 MB')
    """
    return (
        f"{count} bytes"
        if count < 1000
        else f"{count / 1e3:.0f} kB"
        if count < 999_500
        else f"{count / 1e6:.1f} MB"
    )


def sentence_of(error: ValvetrainError, key: str = "") -> str:
    """An error as a sentence; at the field of ``key`` the location is not repeated."""
    text = (
        error.reason
        if key and isinstance(error, InputError) and error.where.endswith(key)
        else str(error)
    )
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "?")) else ".")


_TONES = {"finished": "good", "failed": "bad", "cancelled": "warn", "interrupted": "warn"}


def job_shown(job: JobStatus | None) -> dict[str, Any] | None:
    """A job for its panel; None for none."""
    if job is None:
        return None
    going = not job.ended
    text_of = job.text if going else job.error
    if job.state == "running":
        left = job.seconds_left
        left_text = "" if left is None else f"about {duration_text(left)} left"
        text_of = ", ".join(filter(None, (f"{100 * job.share:.0f} %", job.text, left_text)))
    if job.state == "cancelled" and not text_of:
        text_of = (
            "Cancelled. What was finished is saved."
            if job.run_id
            else "Cancelled before anything was finished."
        )
    if job.state == "queued":
        text_of = text_of or "Waits for the job before it."
    return {
        "id": job.job_id,
        "title": job.kind.capitalize(),
        "state": job.state,
        "tone": _TONES.get(job.state, ""),
        "going": going,
        "percent": round(100 * job.share),
        "words": text_of,
        "again": job.state in ("failed", "cancelled", "interrupted"),
    }
