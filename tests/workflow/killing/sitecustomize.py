"""Put on PYTHONPATH by a test: kills a command while it writes, once for each kind of file.

Python imports a module of this name first. The command dies by SIGKILL, as if the kernel ran out of
memory, when half of a file is written that is about to get its final name.
"""

import os
import signal
import sys
from pathlib import Path

if any(argument.endswith("/sensory-commutativity") for argument in sys.orig_argv):
    replace = os.replace

    def kill_while_writing(source, target, **options):
        try:
            Path(os.environ["KILLED"], Path(target).suffix).touch(exist_ok=False)
        except FileExistsError:
            return replace(source, target, **options)
        os.truncate(source, Path(source).stat().st_size // 2)
        return os.kill(os.getpid(), signal.SIGKILL)

    os.replace = kill_while_writing
