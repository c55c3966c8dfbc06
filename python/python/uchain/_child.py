"""The command ``uchain`` of a campaign, which ends with the process that has begun it."""

import os
import signal
import sys
import threading

from .__main__ import main


def end_with_parent() -> None:
    """Ask the command to end when its standard input ends: the process that has begun it is gone then.

    As after Ctrl-C, the missions that have begun are flown to their ends.
    """
    while os.read(0, 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    threading.Thread(target=end_with_parent, daemon=True).start()
    sys.exit(main())
