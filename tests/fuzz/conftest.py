"""The machines of the runtime's tests, for the campaigns' samples."""

from tests.runtime.conftest import driven, make, mechanisms, pendulum, workshop

__all__ = ["driven", "make", "mechanisms", "pendulum", "workshop"]
