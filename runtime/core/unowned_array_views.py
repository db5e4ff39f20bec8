"""Arrays that compiled code borrows: they own nothing, and cost nothing.

The base must outlive them, which holds for workspaces: the caller of compiled code owns them.
"""

from collections.abc import Callable
from typing import Any

from codegen.machine_code import table_values

view: Callable[[Any, int, int | tuple[int, int]], Any] = table_values.view
"""A contiguous array in a flat float64 or int64 one from element `start` on; bounds unchecked.

The last argument is its length, or its numbers of rows and columns.
"""
