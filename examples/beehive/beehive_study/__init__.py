"""The beehive of Gu, Hou, Keating and Ye (2021) beyond its case files: how its unpublished numbers were found, and the tables of
docs/beehive.md.

``identification`` computes points of the blind case for ``valvetrain identify identify.toml``; ``refit`` writes what it finds into the
case library; ``page`` writes docs/beehive.md; ``modal`` has the modal model of the source as its equations print it.
"""
