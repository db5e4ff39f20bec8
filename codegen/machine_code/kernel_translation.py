"""The kernels of a text → a module in LLVM's language, with the functions and tables they use."""

import ast
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

import numba
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types

from codegen.machine_code.expression_translation import (
    DOUBLE,
    INTEGER,
    POINTER,
    Array,
    ExpressionTranslation,
    Number,
    UntranslatableError,
    Value,
    number_of,
    signed,
)

_config: Any = numba.config  # numba leaves its names untyped
_types: Any = types
_KINDS: dict[Any, Any] = {types.float64: DOUBLE, types.int64: INTEGER}
_ITEMS = {"float64": DOUBLE, "int64": INTEGER, "uint32": ir.IntType(32)}  # numpy's names of kinds
# An array in machine code, by numba: owner, parent, size, item's size, data, length and stride.
_WORDS = (POINTER, POINTER, INTEGER, INTEGER, POINTER, INTEGER, INTEGER)
_ARRAY = ir.LiteralStructType([*_WORDS[:5], *[ir.ArrayType(INTEGER, 1)] * 2])
_BLOCKS = (ast.If, ast.For, ast.While)


class KernelModule:
    """The module of a text's kernels; other parts enter when something first uses them.

    UntranslatableError at what no kernel has.

    Attributes
    ----------
    names
        Those that the text knows.
    flags
        What the optimizer may do with floating-point numbers, as in ("contract",).
    """

    def __init__(
        self, names: Mapping[str, Any], text: str, options: Mapping[str, Any], prefix: str
    ) -> None:
        fastmath = options.get("fastmath") or ()
        checks = options.get("boundscheck") or _config.BOUNDSCHECK
        if options.get("error_model") != "numpy" or fastmath is True or checks:
            raise UntranslatableError(f"kernels with the options {options}")
        self.names, self.flags = names, tuple(sorted(fastmath))
        self._options, self._prefix = options, prefix
        self._llvm = ir.Module()
        self._llvm.triple = ""
        self._trees = {
            min(node.lineno, *(one.lineno for one in node.decorator_list)): node
            for node in ast.parse(text).body
            if isinstance(node, ast.FunctionDef) and node.decorator_list
        }
        self._callees: dict[tuple[Any, ...], tuple[Any, Sequence[Any], Sequence[Any]]] = {}

    def __str__(self) -> str:
        return str(self._llvm)

    def table(self, name: str, values: Any) -> Array:
        """An array that the text knows, as a constant."""
        kind = _ITEMS.get(str(values.dtype))
        if kind is None or not (values.ndim and values.flags.c_contiguous):
            raise UntranslatableError(f"the array {name}")
        table = self._llvm.globals.get(f"table.{name}")
        if table is None:
            whole = ir.ArrayType(kind, values.size)
            table = ir.GlobalVariable(self._llvm, whole, f"table.{name}")
            table.linkage, table.global_constant, table.unnamed_addr = "internal", True, True
            table.initializer = whole(values.ravel().tolist())
        return Array(table, kind, tuple(map(INTEGER, values.shape)))

    def external(self, name: str, arguments: int) -> Any:
        """A function elsewhere, from floating-point numbers to one."""
        function = self.function(name, DOUBLE, *[DOUBLE] * arguments)
        if not name.startswith("llvm."):
            function.attributes.add("readonly")
            function.attributes.add("nounwind")
        return function

    def function(self, name: str, result: Any, *kinds: Any) -> Any:
        """A function elsewhere, of these kinds."""
        found = self._llvm.globals.get(name)
        return found or ir.Function(self._llvm, ir.FunctionType(result, kinds), name)

    def add(self, kernel: Any, symbol: str) -> None:
        """Add a kernel as numba's callers know it: an array is seven arguments of machine code."""
        kinds, results = kernel.declared.args, _results(kernel.declared)
        words = [_WORDS if isinstance(kind, _types.Array) else [_number(kind)] for kind in kinds]
        parts = [POINTER, POINTER, *(word for some in words for word in some)]
        function = ir.Function(self._llvm, ir.FunctionType(ir.IntType(32), parts), symbol)
        for argument in function.args[:2]:  # of the results, and of an exception
            argument.add_attribute("noalias")
        rest = iter(function.args[2:])
        given = [[*islice(rest, len(some))] for some in words]
        self._translate(kernel, function, [*map(_value, kinds, given)], results, function.args[0])
        if len(results) < 2:
            self._add_entry_from_c(function, kinds, *(results or (POINTER,)))

    def callee(self, name: str, given: Sequence[Any]) -> tuple[Any, Sequence[Any], Sequence[Any]]:
        """A function of the text for arguments of these kinds, what it takes and returns.

        What the text does not declare returns floating-point numbers.
        """
        kernel = self.names[name]
        declared = getattr(kernel, "declared", None)
        kinds = given if declared is None else [*map(_number, declared.args)]
        key = (name, *map(str, kinds))
        if key not in self._callees:
            returned = (DOUBLE,) * _count_of_results(self._tree(kernel))
            results = returned if declared is None else _results(declared)
            kind = results[0] if len(results) == 1 else ir.LiteralStructType(results)
            symbol = f"{self._prefix}{name}.{len(self._callees)}"
            function = ir.Function(self._llvm, ir.FunctionType(kind, kinds), symbol)
            function.linkage = "internal"
            function.attributes.add("alwaysinline")
            self._callees[key] = function, kinds, results
            self._translate(kernel, function, function.args, results)
        return self._callees[key]

    def _tree(self, kernel: Any) -> ast.FunctionDef:
        code: Any = getattr(getattr(kernel, "py_func", None), "__code__", None)
        tree = self._trees.get(getattr(code, "co_firstlineno", 0))
        if tree is None or tree.name != code.co_name:
            raise UntranslatableError(f"{kernel} is no function of the text")
        return tree

    def _translate(
        self, kernel: Any, function: Any, values: Sequence[Any], results: Sequence[Any],
        place: Any = None,
    ) -> None:  # fmt: skip
        tree = self._tree(kernel)
        is_declared = kernel.declared is not None
        if kernel.options != self._options or len(tree.args.args) != len(values):
            raise UntranslatableError(f"{tree.name} is not declared as the others")
        parameters = dict(zip((one.arg for one in tree.args.args), values, strict=True))
        FunctionTranslation(self, function, results, place, is_declared).run(tree, parameters)

    def _add_entry_from_c(self, function: Any, kinds: Sequence[Any], result: Any) -> None:
        """A function that calls a kernel and returns what it stores; an array is a structure."""
        taken = [_ARRAY if isinstance(kind, _types.Array) else _number(kind) for kind in kinds]
        entry = ir.Function(self._llvm, ir.FunctionType(result, taken), f"{function.name}.c")
        code = ir.IRBuilder(entry.append_basic_block())
        place, exception = code.alloca(result), code.alloca(POINTER)
        words = [code.bitcast(place, POINTER), code.bitcast(exception, POINTER)]
        for argument in entry.args:
            if argument.type == _ARRAY:
                places = (0, 1, 2, 3, 4, (5, 0), (6, 0))
                words += [code.extract_value(argument, place) for place in places]
            else:
                words.append(argument)
        code.call(function, words)
        code.ret(code.load(place, typ=result))


def _number(kind: Any) -> Any:
    if kind not in _KINDS:
        raise UntranslatableError(str(kind))
    return _KINDS[kind]


def _value(kind: Any, words: Sequence[Any]) -> Any:
    """An argument of a kernel, of its words in machine code."""
    if not isinstance(kind, _types.Array):
        return words[0]
    if kind.ndim != 1 or kind.layout != "C":
        raise UntranslatableError(str(kind))
    return Array(words[4], _number(kind.dtype), (words[5],))


def _results(signature: Any) -> tuple[Any, ...]:
    """Kinds of what a function returns."""
    result = signature.return_type
    each = result if isinstance(result, _types.BaseTuple) else (result,)
    return tuple(_number(one) for one in each if one != _types.none)


def _count_of_results(tree: ast.FunctionDef) -> int:
    for node in ast.walk(tree):
        if isinstance(node, ast.Return) and node.value is not None:
            return len(node.value.elts) if isinstance(node.value, ast.Tuple) else 1
    raise UntranslatableError(f"{tree.name}, which returns nothing")


def _stands_in_places(counter: str, body: list[ast.stmt]) -> bool:
    """Whether a counter is in places of arrays only, where a sign makes no difference to numba."""
    nodes = {node for statement in body for node in ast.walk(statement)}
    places = [node.slice for node in nodes if isinstance(node, ast.Subscript)]
    within = {node for place in places for node in ast.walk(place)}
    return not any(isinstance(x, ast.Name) and x.id == counter for x in nodes - within)


class FunctionTranslation(ExpressionTranslation):
    """The translation of one function; UntranslatableError at what no kernel has.

    A name that is assigned once, and not within a block, is the value itself; another one is a
    place in memory, which the optimizer turns into values.

    Attributes
    ----------
    results
        Kinds of what it returns.
    place
        Where a kernel stores that: it returns that all went well. None for what kernels call.
    is_declared
        Whether the kinds are those of a signature, into which it converts what it returns.
    """

    def __init__(
        self, module: KernelModule, function: Any, results: Sequence[Any], place: Any,
        is_declared: bool,
    ) -> None:  # fmt: skip
        super().__init__(module, function)
        self.results, self.place, self.is_declared = results, place, is_declared
        self._changing: frozenset[str] = frozenset()

    def run(self, tree: ast.FunctionDef, parameters: Mapping[str, Value]) -> None:
        """Translate its body."""
        first = self._code.block
        times = Counter([*parameters])  # that a name gets a value
        nested: set[str] = set()
        for statement in tree.body:
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    times[node.id] += 1
                    if isinstance(statement, _BLOCKS):
                        nested.add(node.id)
        self._locals = frozenset(times)
        self._changing = frozenset(nested | {name for name, count in times.items() if count > 1})
        for name, value in parameters.items():
            self._assign(name, value)
        self._statements(tree.body)
        if not self._code.block.is_terminated:
            self._return(None)
        self._beginning.branch(first)

    def _statements(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            if not self._code.block.is_terminated:  # else nothing gets here
                self._statement(statement)

    def _statement(self, statement: ast.stmt) -> None:
        match statement:
            case ast.Assign(targets=[target], value=value):
                self._store(target, self._value(value))
            case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                before = self._number(ast.Name(name))
                self._assign(name, self._calculation(op, before, self._number(value)))
            case ast.Expr(value=ast.Constant()) | ast.Pass():  # an expression that documents
                pass
            case ast.If(test=test, body=body, orelse=other):
                self._if(test, body, other)
            case ast.For(
                target=ast.Name(id=name), orelse=[], body=body,
                iter=ast.Call(func=ast.Name(id="range"), args=[*first, last], keywords=[]),
            ) if len(first) < 2:  # fmt: skip
                bounds = [self._as(INTEGER, self._number(x)) for x in (*first, last)]
                if not _stands_in_places(name, body):
                    bounds = [*map(signed, bounds)]
                start, stop = [INTEGER(0), *bounds][-2:]
                self._for(name, start, stop, body)
            case ast.While(test=test, body=body, orelse=[]):
                self._while(test, body)
            case ast.Return(value=value):
                self._return(value)
            case _:
                raise UntranslatableError(statement)

    def _store(self, target: ast.expr, value: Value) -> None:
        match target:
            case ast.Name(id=name):
                self._assign(name, value)
            case ast.Tuple(elts=targets) if isinstance(value, tuple) and len(value) == len(targets):
                for one, number in zip(targets, value, strict=True):
                    self._store(one, number)
            case ast.Subscript():
                array, address = self._element(target)
                if isinstance(array.address, ir.GlobalVariable):  # a table
                    raise UntranslatableError(target)
                self._code.store(self._as(array.kind, number_of(value)), address)
            case _:
                raise UntranslatableError(target)

    def _assign(self, name: str, value: Value) -> None:
        if name not in self._changing:
            self._values[name] = value
            return
        number = signed(number_of(value))
        if name not in self._places:
            self._places[name] = self._beginning.alloca(number.type), number.type
        address, kind = self._places[name]
        if kind != number.type:
            raise UntranslatableError(f"{name} is of two kinds")  # numba makes it both
        self._code.store(number, address)

    def _go_on(self, block: Any) -> None:
        if not self._code.block.is_terminated:
            self._code.branch(block)

    def _if(self, test: ast.expr, body: list[ast.stmt], other: list[ast.stmt]) -> None:
        yes, no, behind = self._blocks(3)
        self._branch(test, yes, no)
        goes_on = False
        for block, statements in ((yes, body), (no, other)):
            self._begin(block)
            self._statements(statements)
            goes_on = goes_on or not self._code.block.is_terminated
            self._go_on(behind)
        if goes_on:
            self._begin(behind)

    def _for(self, name: str, start: Number, stop: Number, body: list[ast.stmt]) -> None:
        code = self._code
        counter = self._beginning.alloca(INTEGER)
        code.store(start, counter)
        test, turn, behind = self._blocks(3)
        code.branch(test)
        self._begin(test)
        place = code.load(counter, typ=INTEGER)
        code.cbranch(code.icmp_signed("<", place, stop), turn, behind)
        self._begin(turn)
        self._assign(name, place)
        code.store(code.add(place, INTEGER(1), flags=("nsw",)), counter)
        self._statements(body)
        self._go_on(test)
        self._begin(behind)

    def _while(self, condition: ast.expr, body: list[ast.stmt]) -> None:
        test, turn, behind = self._blocks(3)
        self._code.branch(test)
        self._begin(test)
        self._branch(condition, turn, behind)
        self._begin(turn)
        self._statements(body)
        self._go_on(test)
        self._begin(behind)

    def _return(self, expression: ast.expr | None) -> None:
        value = () if expression is None else self._value(expression)
        given = value if isinstance(value, tuple) else (number_of(value),)
        as_is = self.is_declared or all(number.type == DOUBLE for number in given)
        if len(given) != len(self.results) or not as_is:
            raise UntranslatableError(f"a return of {len(given)} numbers")
        numbers = [*map(self._as, self.results, given)]
        for address in self._on_heap:
            self._code.call(self.module.function("free", ir.VoidType(), POINTER), [address])
        if len(numbers) == 1:
            (one,) = numbers
        elif numbers:
            one = ir.LiteralStructType(self.results)(ir.Undefined)
            for place, number in enumerate(numbers):
                one = self._code.insert_value(one, number, place)
        else:
            one = POINTER(None)
        if self.place is None:
            self._code.ret(one)
        else:
            self._code.store(one, self.place)
            self._code.ret(ir.IntType(32)(0))
