"""Calling Chipmunk from compiled code.

pymunk builds the space; the loop over sub-steps is compiled by numba and calls Chipmunk's own C functions through their addresses, because a
Python call per body and sub-step would take three times as long as the physics. Only functions of pymunk's batch interface and
``cpSpaceStep`` are used; this file is the only one that touches pymunk's private parts, and a test compares it with pymunk's public ones.
"""

from __future__ import annotations

import ctypes

import numpy as np
from pymunk import Body, Space
from pymunk._chipmunk_cffi import ffi, lib
from pymunk.batch import BodyFields, Buffer

_WORD = ctypes.c_size_t  # an address


def _address(pointer) -> int:
    return int(ffi.cast("uintptr_t", pointer))


def _function(name: str, *arguments):
    return ctypes.CFUNCTYPE(None, *arguments)(_address(ffi.addressof(lib, name)))


STEP = _function("cpSpaceStep", _WORD, ctypes.c_double)
"""STEP(space, dt): integrate positions, find contacts, solve velocities."""

READ_BODY = _function("pmSpaceBodyGetIteratorFuncBatched", _WORD, _WORD)
"""READ_BODY(body, channel): append the channel's fields of the body to its array."""

WRITE_BODY = _function("pmSpaceBodySetIteratorFuncBatched", _WORD, _WORD)
"""WRITE_BODY(body, channel): set the channel's fields of the body from its array."""


def body_address(body: Body) -> int:
    return _address(body._body)


def space_address(space: Space) -> int:
    return _address(space._space)


class Channel:
    """A window on some fields of a body: set `cursor[0] = 0`, call READ_BODY or WRITE_BODY with `address`, find the numbers in `values`.

    The numbers stand in the order position x, y; angle; velocity x, y; angular velocity; force x, y; torque; of those asked for.
    """

    def __init__(self, fields: BodyFields):
        self.values = np.zeros(
            16
        )  # more than the nine numbers a body has: Chipmunk must never reallocate it
        self._buffer = Buffer()
        self._buffer.set_float_buf(self.values)
        self._data = ffi.new("pmBatchedData *")
        self._data.fields = fields.value
        self._data.floatArray = self._buffer._float_arr
        self._data.intArray = self._buffer._int_arr
        self.cursor = np.frombuffer(
            ffi.buffer(ffi.addressof(self._buffer._float_arr, "num")), np.int32
        )
        self.address = _address(self._data)


POSE_AND_VELOCITY = (
    BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
)
POSITION_AND_FORCE = BodyFields.POSITION | BodyFields.FORCE | BodyFields.TORQUE
VELOCITY = BodyFields.VELOCITY
