"""`Model`, the declaration of a machine; each file holds one topic."""

from codegen.model.model import Model

__all__ = ["Model"]
