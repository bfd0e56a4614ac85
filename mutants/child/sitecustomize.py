"""Imported by every Python that a test starts while trails are kept; quick, and silent elsewhere."""

import os

if "VALVETRAIN_TRAIL_CHILDREN" in os.environ:
    from mutants.trail import follow_child

    follow_child()
