"""A real Slurm on this machine: one controller and two nodes, for tests and for trying the profile.

    python tests/workflow/slurm.py start FOLDER     installs Debian's Slurm and munge if they are
                                                    missing, starts, prints what to source
    python tests/workflow/slurm.py stop FOLDER

Slurm's daemons need root. Apart from the packages nothing is written outside FOLDER; a Slurm that
this machine belongs to is not touched.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "munged")
NODES = ("n1", "n2")
CPUS, MEMORY = 2, 6000
"""Of each node; MB. Both nodes share this machine, and Slurm does not check."""
PATIENCE = 300
"""Seconds until a daemon must answer."""

CONFIGURATION = """\
ClusterName=tests
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=15
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=2,bf_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
SlurmdTimeout=10
KillWait=2
MinJobAge=3600
OverTimeLimit=0
NodeName={names} NodeHostname={host} NodeAddr=127.0.0.1 Port=[{first}-{last}] CPUs={cpus} \\
RealMemory={memory} State=UNKNOWN
PartitionName=short Nodes={names} Default=YES MaxTime=UNLIMITED DefaultTime=5 DefMemPerCPU=500 \\
State=UP
"""


class SlurmError(RuntimeError):
    """Slurm cannot be started here; says why."""


class Slurm:
    """A controller and two nodes.

    Parameters
    ----------
    folder : Path
        Configuration, state and logs.
    attached : bool
        Whether all daemons die with this process, however it ends; otherwise they run until
        :meth:`stop`.
    """

    def __init__(self, folder: Path, attached: bool = True):
        self.folder, self.attached = folder.resolve(), attached
        self.conf = self.folder / "slurm.conf"

    @property
    def environment(self) -> dict[str, str]:
        """Environment for the commands of this Slurm and of the Python that runs this."""
        path = os.pathsep.join(
            [
                str(self.folder / "bin"),
                str(Path(sys.executable).parent),
                os.environ["PATH"],
                "/usr/sbin",
            ]
        )
        kept = {
            key: value
            for key, value in os.environ.items()
            if not key.startswith(("SLURM", "SBATCH"))
        }
        return {**kept, "SLURM_CONF": str(self.conf), "PATH": path}

    def start(self) -> None:
        """Start all daemons, and return when both nodes are idle. Raises SlurmError."""
        _install()
        for name in ("state", "spool", "bin"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        for node in NODES:
            (self.folder / "spool" / node).mkdir(exist_ok=True)
        port, host = _free_ports(len(NODES) + 1), socket.gethostname()
        self.conf.write_text(
            CONFIGURATION.format(
                host=host,
                port=port,
                folder=self.folder,
                names=",".join(NODES),
                first=port + 1,
                last=port + len(NODES),
                cpus=CPUS,
                memory=MEMORY,
            )
        )
        # snakemake-executor-plugin-slurm-jobstep 0.6 drops SLURM_CONF before it calls srun
        real = shutil.which("srun", path=f"{os.environ['PATH']}:/usr/bin")
        wrapper = self.folder / "bin" / "srun"
        wrapper.write_text(f'#!/bin/sh\nSLURM_CONF={self.conf} exec {real} "$@"\n')
        wrapper.chmod(0o755)
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o600)
        self.folder.chmod(0o755)  # munged needs a folder that everybody can enter
        f = self.folder
        self._begin(
            "munged", "--force", f"--key-file={key}", f"--socket={f}/munge.socket",
            f"--pid-file={f}/munged.pid", f"--log-file={f}/munged.log",
            f"--seed-file={f}/munge.seed", foreground="--foreground",
        )  # fmt: skip
        _wait_for(f / "munge.socket")
        self._begin("slurmctld", foreground="-D")
        for node in NODES:
            self.start_node(node)
        self.wait_for_nodes()

    def start_node(self, node: str) -> None:
        self._begin("slurmd", "-N", node, foreground="-D")
        _wait_for(self.folder / f"slurmd.{node}.pid")

    def wait_for_nodes(self, state: str = "idle", nodes: tuple[str, ...] = NODES) -> None:
        """Return when all `nodes` are in that state. Raises SlurmError after some time."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            output = subprocess.run(
                ["sinfo", "-h", "-N", "-o", "%N %T"],
                env=self.environment,
                capture_output=True,
                text=True,
            ).stdout
            states = dict(line.split() for line in output.splitlines())
            if all(states.get(node, "").startswith(state) for node in nodes):
                return
            time.sleep(0.5)
        raise SlurmError(
            f"nodes are {states or 'silent'} after {PATIENCE} s, not {state}; see the logs in "
            f"{self.folder}"
        )

    def jobs(self, states: str = "RUNNING") -> list[tuple[str, str, str]]:
        """Id, node and comment (which names the rule) of all jobs in these states."""
        output = subprocess.run(
            ["squeue", "-h", "-t", states, "-o", "%A|%N|%k"],
            env=self.environment,
            capture_output=True,
            text=True,
        ).stdout
        return [tuple(line.split("|", 2)) for line in output.splitlines()]

    def lose(self, node: str) -> None:
        """Simulate a power failure: a node's daemon, job steps and their children die at once."""
        pid = self.folder / f"slurmd.{node}.pid"
        doomed = _tree(int(pid.read_text()))
        pid.unlink()
        steps = [
            pid
            for pid in _processes()
            if f"SLURMD_NODENAME={node}" in _environ(pid)
            and f"SLURM_CONF={self.conf}" in _environ(pid)
        ]
        for step in steps:
            doomed |= (
                _tree(_parent(step)) if "slurmstepd" in _command(_parent(step)) else _tree(step)
            )
        for pid in doomed - {os.getpid()}:
            _kill(pid)

    def stop(self) -> None:
        """Stop all daemons; jobs die with them."""
        if not self.conf.exists():
            return
        subprocess.run(
            ["scancel", "--state=RUNNING"], env=self.environment, capture_output=True, timeout=30
        )
        subprocess.run(
            ["scontrol", "shutdown"], env=self.environment, capture_output=True, timeout=30
        )
        time.sleep(2)
        for name in ("slurmctld", *(f"slurmd.{node}" for node in NODES), "munged"):
            pid = self.folder / f"{name}.pid"
            if pid.exists() and pid.read_text().strip():
                _kill(int(pid.read_text()), signal.SIGTERM)

    def _begin(self, *command: str, foreground: str) -> None:
        """Begin a daemon; with the option `foreground` it stays a child of this process."""
        if self.attached:
            log = (self.folder / f"{command[0]}.output").open("ab")
            subprocess.Popen(
                [*command, foreground],
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                preexec_fn=_die_with_parent,
            )
            return
        run = subprocess.run(
            command,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        if run.returncode:
            raise SlurmError(
                f"{command[0]} does not start: {run.stderr.strip()}; see the logs in {self.folder}"
            )


def _die_with_parent() -> None:
    """Ask the kernel for SIGTERM when the parent dies (prctl, PR_SET_PDEATHSIG).

    A test that was killed then leaves no daemons behind.
    """
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)


def _wait_for(path: Path) -> None:
    end = time.monotonic() + PATIENCE
    while not path.exists():
        if time.monotonic() > end:
            raise SlurmError(f"{path} does not appear; see the logs beside it")
        time.sleep(0.1)


def find_obstacle() -> str | None:
    """Why this machine cannot run a Slurm, or None."""
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        return "Slurm's daemons need root on Linux"
    if _missing() and shutil.which("apt-get") is None:
        return f"{', '.join(_missing())} not installed, and no apt-get to install them with"
    return None


def _missing() -> list[str]:
    return [
        program
        for program in PROGRAMS
        if shutil.which(program, path=f"{os.environ['PATH']}:/usr/sbin:/sbin") is None
    ]


def _install() -> None:
    if not _missing():
        return
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    install = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
    run = subprocess.run(install, env=environment, capture_output=True, text=True)
    if run.returncode:  # the package lists may be old
        subprocess.run(["apt-get", "update"], env=environment, capture_output=True)
        run = subprocess.run(install, env=environment, capture_output=True, text=True)
    if run.returncode:
        raise SlurmError(
            f"cannot install {', '.join(PACKAGES)}: {run.stderr.strip().splitlines()[-1:]}"
        )


def _free_ports(n: int) -> int:
    """The first of `n` consecutive free ports."""
    for first in range(21000 + os.getpid() % 8000, 32000, n):
        try:
            sockets = []
            for port in range(first, first + n):
                sockets.append(socket.create_server(("127.0.0.1", port)))
            return first
        except OSError:
            continue
        finally:
            for opened in sockets:
                opened.close()
    raise SlurmError("no free ports")


def _processes() -> list[int]:
    return [int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit()]


def _read(pid: int, name: str) -> str:
    try:
        return Path(f"/proc/{pid}/{name}").read_bytes().decode(errors="replace")
    except OSError:
        return ""


def _environ(pid: int) -> list[str]:
    return _read(pid, "environ").split("\0")


def _command(pid: int) -> str:
    return _read(pid, "cmdline").replace("\0", " ")


def _parent(pid: int) -> int:
    fields = _read(pid, "stat").rpartition(")")[2].split()
    return int(fields[1]) if fields else 0


def _tree(root: int) -> set[int]:
    """A process and all its descendants."""
    parents = {pid: _parent(pid) for pid in _processes()}
    tree, grown = {root}, True
    while grown:
        more = {pid for pid, parent in parents.items() if parent in tree} - tree
        tree, grown = tree | more, bool(more)
    return tree


def _kill(pid: int, how: int = signal.SIGKILL) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, how)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("command", choices=["start", "stop"])
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    slurm = Slurm(arguments.folder, attached=False)
    if arguments.command == "stop":
        slurm.stop()
        return
    obstacle = find_obstacle()
    if obstacle:
        sys.exit(obstacle)
    try:
        slurm.start()
    except SlurmError as error:
        sys.exit(str(error))
    print(f"export SLURM_CONF={slurm.conf} PATH={slurm.folder / 'bin'}:$PATH")


if __name__ == "__main__":
    main()
