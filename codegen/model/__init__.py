"""`Model`, what a modeller holds: one file a topic."""

from codegen.model.model import Model

__all__ = ["Model"]
