"""LLVM's engine finds a module by its address, however many modules it has."""

from collections.abc import Callable
from typing import Any

import pytest
from llvmlite import binding  # type: ignore[import-untyped]
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from codegen import loaded_llvm_modules
from codegen.loaded_llvm_modules import ModulesByAddress, find_modules_by_address
from codegen.separate_compilation import separate_compilation

TEXT = """
target triple = "{}"
define i64 @"twice.{}"(i64 %n) {{
  %m = add i64 %n, %n
  ret i64 %m
}}
"""


@pytest.fixture
def engine() -> Any:
    """An engine of its own."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine()
    return binding.create_mcjit_compiler(module("first"), machine)


def module(name: str) -> Any:
    return binding.parse_assembly(TEXT.format(binding.get_default_triple(), name))


def test_modules_are_found_by_their_addresses(engine: Any) -> None:
    (first,) = engine._modules
    find_modules_by_address(engine)
    find_modules_by_address(engine)  # changes nothing more
    second, foreign = module("second"), module("foreign")
    engine.add_module(second)
    assert engine._find_module_ptr(first._ptr) is first
    assert engine._find_module_ptr(second._ptr) is second
    assert engine._find_module_ptr(foreign._ptr) is None
    engine.finalize_object()
    assert engine.get_function_address("twice.second")
    engine.remove_module(second)
    assert engine._find_module_ptr(second._ptr) is None


@pytest.mark.parametrize("number", [4, 40])
def test_a_module_is_found_in_one_look(
    number: int, engine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    find_modules_by_address(engine)
    modules = [module(f"m{k}") for k in range(number)]
    for one in modules:
        engine.add_module(one)
    looks: list[Any] = []
    address: Callable[[Any], Any] = loaded_llvm_modules._address
    monkeypatch.setattr(loaded_llvm_modules, "_address", lambda p: looks.append(p) or address(p))
    assert engine._find_module_ptr(modules[-1]._ptr) is modules[-1]
    assert len(looks) == 1


def test_what_numba_compiles_for_us_is_found_so() -> None:
    with global_compiler_lock, separate_compilation():
        library = cpu_target.target_context.codegen().create_library("probe")
        library.add_llvm_module(module("probe"))
        library.finalize()
    engine = library._codegen._engine._ee
    assert isinstance(engine._modules, ModulesByAddress)
    assert all(engine._find_module_ptr(one._ptr) is one for one in engine._modules)
