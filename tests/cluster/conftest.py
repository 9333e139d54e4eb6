"""The local run, made once for all tests, is the workflow's."""

from ..workflow.conftest import finished  # noqa: F401
