"""One function of a kernel's text → instructions of LLVM's, statement by statement."""

import ast
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from codegen.machine_code.expression_translation import ExpressionTranslation, number_of, signed
from codegen.machine_code.llvm_instructions import (
    INTEGER,
    Group,
    Number,
    UntranslatableError,
    Value,
    integer_literal,
)

if TYPE_CHECKING:
    from codegen.machine_code.llvm_module import LlvmModule

_BLOCKS = (ast.If, ast.For, ast.While)


class FunctionTranslation(ExpressionTranslation):
    """The translation of one function; UntranslatableError at what no kernel has.

    A name that is assigned once, and not within a block, is the value itself; another one is a
    place in memory, which the optimizer turns into values.

    Attributes
    ----------
    results
        Kinds of what it returns.
    """

    def __init__(
        self,
        module: "LlvmModule",
        parameters: Mapping[str, Value],
        results: tuple[str, ...] = (),
        is_kernel: bool = False,
    ) -> None:
        """Of a function that a kernel calls, which may declare the kinds of its results."""
        super().__init__(module, parameters)
        self.results = results
        self._is_kernel = is_kernel
        self._changing: frozenset[str] = frozenset()

    def run(self, tree: ast.FunctionDef) -> None:
        """Translate its body."""
        self._changing = _changing(tree)
        self._locals = frozenset(
            node.id
            for node in ast.walk(tree)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        ) | frozenset(parameter.arg for parameter in tree.args.args)
        for name in sorted(self._changing & self._values.keys()):
            self._assign(name, self._values.pop(name))
        self._statements(tree.body)
        if self.code.block is not None:
            self._return(None)

    def _statements(self, statements: Sequence[ast.stmt]) -> None:
        for statement in statements:
            if self.code.block is not None:  # else nothing gets here
                self._statement(statement)

    def _statement(self, statement: ast.stmt) -> None:
        match statement:
            case ast.Assign(targets=[target], value=value):
                self._store(target, self._value(value))
            case ast.AugAssign(target=ast.Name() as target, op=op, value=value):
                before = self._number(target)
                self._store(target, self._calculation(op, before, self._number(value)))
            case ast.Expr(value=ast.Constant()) | ast.Pass():  # an expression that documents
                pass
            case ast.If(test=test, body=body, orelse=other):
                self._if(test, body, other)
            case ast.For(target=ast.Name(id=name), iter=turns, body=body, orelse=[]):
                self._for(name, turns, body)
            case ast.While(test=test, body=body, orelse=[]):
                self._while(test, body)
            case ast.Return(value=value):
                self._return(value)
            case _:
                raise UntranslatableError(ast.unparse(statement))

    def _store(self, target: ast.expr, value: Value) -> None:
        match target, value:
            case ast.Name(id=name), _:
                self._assign(name, value)
            case ast.Tuple(elts=targets), Group(numbers) if len(targets) == len(numbers):
                for one, number in zip(targets, numbers, strict=True):
                    self._store(one, number)
            case ast.Subscript(), Number():
                array, place = self._element(target)
                if array.address.startswith("@"):
                    raise UntranslatableError(f"{ast.unparse(target)} of a table")
                self.code.store(self._as(array.kind, value), self.code.element(array, place))
            case _:
                raise UntranslatableError(ast.unparse(target))

    def _assign(self, name: str, value: Value) -> None:
        if name not in self._changing:
            self._values[name] = value
            return
        if not isinstance(value, Number):
            raise UntranslatableError(f"{name}, which changes, is no number")
        if name not in self._variables:
            self._variables[name] = replace(value, text=self.code.variable(value.kind))
        variable = self._variables[name]
        if (variable.kind, variable.unsigned) != (value.kind, value.unsigned):  # numba has both
            raise UntranslatableError(f"{name} is of two kinds")
        self.code.store(value, variable.text)

    def _if(self, test: ast.expr, body: list[ast.stmt], other: list[ast.stmt]) -> None:
        code = self.code
        yes, no, behind = code.label(), code.label(), code.label()
        self._branch(test, yes, no)
        goes_on = False
        for label, statements in ((yes, body), (no, other)):
            code.begin(label)
            self._statements(statements)
            goes_on = goes_on or code.block is not None
            code.jump(behind)
        if goes_on:
            code.begin(behind)

    def _for(self, name: str, turns: ast.expr, body: list[ast.stmt]) -> None:
        code = self.code
        match turns:
            case ast.Call(func=ast.Name(id="range"), args=[stop], keywords=[]):
                first, last = integer_literal(0), signed(self._integer(stop))
            case ast.Call(func=ast.Name(id="range"), args=[start, stop], keywords=[]):
                first, last = signed(self._integer(start)), signed(self._integer(stop))
            case _:
                raise UntranslatableError(ast.unparse(turns))
        counter = code.variable(INTEGER)
        code.store(first, counter)
        test, turn, behind = code.label(), code.label(), code.label()
        code.begin(test)
        place = code.load(counter, INTEGER)
        code.branch(code.comparison("<", place, last), turn, behind)
        code.begin(turn)
        self._assign(name, place)
        code.store(code.calculation("add nsw", place, integer_literal(1)), counter)
        self._statements(body)
        code.jump(test)
        code.begin(behind)

    def _while(self, condition: ast.expr, body: list[ast.stmt]) -> None:
        code = self.code
        test, turn, behind = code.label(), code.label(), code.label()
        code.begin(test)
        self._branch(condition, turn, behind)
        code.begin(turn)
        self._statements(body)
        code.jump(test)
        code.begin(behind)

    def _return(self, expression: ast.expr | None) -> None:
        """A kernel stores what it returns where its caller says, and returns that all went well."""
        value = Group(()) if expression is None else self._value(expression)
        numbers = value.numbers if isinstance(value, Group) else (number_of(value),)
        if not self._is_kernel and not self.results:
            self.results = tuple(signed(number).kind for number in numbers)
        if len(numbers) != len(self.results):
            raise UntranslatableError(f"a return of {len(numbers)} numbers")
        numbers = tuple(map(self._as, self.results, numbers))
        if numbers:
            one = numbers[0] if len(numbers) == 1 else self.code.packed(Group(numbers))
        elif self._is_kernel:
            one = Number("null", "ptr")
        else:
            raise UntranslatableError("a function that returns nothing")
        if self._is_kernel:
            self.code.store(one, "%.results")
            self.code.end("ret i32 0")
        else:
            self.code.end(f"ret {one}")


def _changing(tree: ast.FunctionDef) -> frozenset[str]:
    """The names that are assigned more than once, or within a block; a parameter has a value."""
    names = Counter(parameter.arg for parameter in tree.args.args)
    nested: set[str] = set()
    for statement in tree.body:
        found = [
            node.id
            for node in ast.walk(statement)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        ]
        names.update(found)
        nested.update(found if isinstance(statement, _BLOCKS) else ())
    return frozenset(nested | {name for name, times in names.items() if times > 1})
