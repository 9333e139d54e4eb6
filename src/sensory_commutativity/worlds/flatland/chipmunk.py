"""Calls to Chipmunk, the engine behind pymunk, from compiled code.

pymunk builds the space. The loop over sub-steps is compiled by numba and calls Chipmunk's C
functions by address: a Python call per body and sub-step would take three times as long as the
physics itself. Only ``cpSpaceStep`` and the functions of pymunk's batch interface are called. No
other module uses private parts of pymunk; the tests compare it with pymunk's public interface.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from pymunk import Body, Space
from pymunk._chipmunk_cffi import ffi, lib
from pymunk.batch import BodyFields, Buffer

_ADDRESS = ctypes.c_size_t


def _address(pointer) -> int:
    return int(ffi.cast("uintptr_t", pointer))


def _function(name: str, *arguments) -> Callable[..., None]:
    return ctypes.CFUNCTYPE(None, *arguments)(_address(ffi.addressof(lib, name)))


class Engine(NamedTuple):
    """Chipmunk's functions.

    Compiled code takes them as arguments: numba cannot cache code that holds their addresses.
    """

    step: Callable[..., None]
    """step(space, dt): integrate positions, find contacts, solve velocities."""
    read_body: Callable[..., None]
    """read_body(body, channel): append the channel's fields of the body to its array."""
    write_body: Callable[..., None]
    """write_body(body, channel): set the channel's fields of the body from its array."""


ENGINE = Engine(
    _function("cpSpaceStep", _ADDRESS, ctypes.c_double),
    _function("pmSpaceBodyGetIteratorFuncBatched", _ADDRESS, _ADDRESS),
    _function("pmSpaceBodySetIteratorFuncBatched", _ADDRESS, _ADDRESS),
)

POSE_AND_VELOCITY = (
    BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
)
POSITION_AND_FORCE = BodyFields.POSITION | BodyFields.FORCE | BodyFields.TORQUE
VELOCITY = BodyFields.VELOCITY


def body_address(body: Body) -> int:
    return _address(body._body)


def space_address(space: Space) -> int:
    return _address(space._space)


class Channel:
    """An array through which compiled code reads or writes some fields of a body.

    Set ``cursor[0] = 0`` and call :attr:`Engine.read_body` or :attr:`Engine.write_body` with
    `address`.

    Parameters
    ----------
    fields : BodyFields

    Attributes
    ----------
    values : float64 (16,)
        The chosen fields, in this order: position x, y; angle; velocity x, y; angular velocity;
        force x, y; torque. A body has nine numbers: Chipmunk must never reallocate the array.
    cursor : int32 (1,)
        How many numbers have been read or written.
    address : int
    """

    def __init__(self, fields: BodyFields):
        self.values = np.zeros(16)
        self._buffer = Buffer()
        self._buffer.set_float_buf(self.values)
        self._data = ffi.new("pmBatchedData *")
        self._data.fields = fields.value
        self._data.floatArray = self._buffer._float_arr
        self._data.intArray = self._buffer._int_arr
        count = ffi.buffer(ffi.addressof(self._buffer._float_arr, "num"))
        self.cursor = np.frombuffer(count, np.int32)
        self.address = _address(self._data)
