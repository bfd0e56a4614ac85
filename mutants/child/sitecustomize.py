"""Imported by every Python that the tool or one of its tests starts; quick, and silent elsewhere."""

import os

if "VALVETRAIN_TRAIL_CHILDREN" in os.environ:
    from mutants.trail import follow_child

    follow_child()
if "VALVETRAIN_MUTANTS_STAMP" in os.environ:
    from mutants.stamp import install

    install()
