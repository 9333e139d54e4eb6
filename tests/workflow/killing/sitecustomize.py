"""Put on PYTHONPATH by a test: kills a command in the middle of writing, once for each kind of file.

Python imports a module of this name before all else. The command dies by SIGKILL, as by the kernel's hand when memory runs out, when half of the file
is written that it is about to give its name.
"""

import os
import signal
import sys
from pathlib import Path

if any(argument.endswith("/sensory-commutativity") for argument in sys.orig_argv):
    whole = os.replace

    def half(source, target, **how):
        try:
            Path(os.environ["KILLED"], Path(target).suffix).touch(exist_ok=False)
        except FileExistsError:
            return whole(source, target, **how)
        os.truncate(source, Path(source).stat().st_size // 2)
        return os.kill(os.getpid(), signal.SIGKILL)

    os.replace = half
