"""Processes that hold an object, answer calls of its methods, and copy themselves when told to."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

from ..errors import WorldError

_FORK = "fork"
"""What a process is told so that it copies itself; then it waits."""


def send(channel: socket.socket, message: Any) -> None:
    with _connection(channel) as connection:
        connection.send(message)


def receive(channel: socket.socket) -> Any:
    with _connection(channel) as connection:
        try:
            error, result = connection.recv()
        except EOFError:
            raise WorldError("the process of the environment ended unexpectedly") from None
    if error is not None:
        raise error
    return result


@contextmanager
def _connection(channel: socket.socket) -> Iterator[Connection]:
    """The channel as a connection that carries Python objects; the channel stays open."""
    connection = Connection(channel.fileno())
    try:
        yield connection
    finally:
        connection._handle = None  # type: ignore[attr-defined]  # belongs to the channel


def fork_from(holder: socket.socket) -> socket.socket:
    """Let the process at the other end copy itself; returns the channel of the copy."""
    ours, theirs = socket.socketpair()
    send(holder, (_FORK, (), {}))
    socket.send_fds(holder, [b"f"], [theirs.fileno()])
    theirs.close()
    receive(ours)  # the copy has started
    return ours


def serve(env: Any, channel: socket.socket) -> None:
    """Answer calls until nobody is at the other end; never returns."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # copies are not waited for
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends its processes
    try:
        while True:
            with _connection(channel) as connection:
                method, arguments, keywords = connection.recv()
            if method == _FORK:
                _, descriptors, _, _ = socket.recv_fds(channel, 1, 1)
                copied = socket.socket(fileno=descriptors[0])
                if os.fork() == 0:
                    channel.close()
                    channel = copied
                    with _connection(channel) as connection:
                        connection.send((None, None))
                else:
                    copied.close()
                continue
            answer: tuple[Exception | None, Any]
            try:
                answer = (None, getattr(env, method)(*arguments, **keywords))
            except Exception as error:
                answer = (WorldError(f"{type(error).__name__}: {error}"), None)
            with _connection(channel) as connection:
                connection.send(answer)
    except (EOFError, OSError):
        pass
    finally:
        os._exit(0)
