"""``python -m valvetrain``: the command line."""

from valvetrain.cli.main import main

main()
