"""The way in of ``valvetrain`` and ``python -m valvetrain``: the command line, ended without a word
by Ctrl-C while it loads.
"""

import gc
import signal


def main() -> None:
    """The console script."""
    if (
        signal.getsignal(signal.SIGINT) is signal.default_int_handler
    ):  # left alone where the parent chose otherwise
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # The libraries make hundreds of thousands of objects that stay; looking through them takes a twentieth of a run.
    gc.set_threshold(50_000, 20, 50)
    from valvetrain.cli.main import main as command

    command()


if __name__ == "__main__":
    main()
