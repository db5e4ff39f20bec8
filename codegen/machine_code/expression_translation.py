"""The expressions of a kernel's text → instructions of LLVM's."""

import ast
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from codegen.machine_code.llvm_instructions import (
    FLOAT,
    INTEGER,
    TRUTH,
    Array,
    Group,
    Instructions,
    Number,
    UntranslatableError,
    Value,
    float_literal,
    integer_literal,
    is_literal,
    structure_of,
)

if TYPE_CHECKING:
    from codegen.machine_code.llvm_module import LlvmModule

# Functions of `math` by the number of their arguments: LLVM's own, and those of the C library.
_INTRINSICS = {**dict.fromkeys(("sin", "cos", "exp", "log"), 1), "pow": 2}
_EXTERNALS = {
    **dict.fromkeys(("sqrt", "floor", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh"), 1),
    "atan2": 2,
}
_BINARY: dict[type, str] = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and"}
_SIGNS: dict[type, str] = {
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
}


class ExpressionTranslation:
    """Evaluates expressions; UntranslatableError at what no kernel has.

    Attributes
    ----------
    module
        What the text knows besides the function's own names.
    code
        The instructions.
    """

    def __init__(self, module: "LlvmModule", parameters: Mapping[str, Value]) -> None:
        self.module = module
        self.code = Instructions(module.flags)
        self._values: dict[str, Value] = dict(parameters)
        self._variables: dict[str, Number] = {}  # its text is the address
        self._locals: frozenset[str] = frozenset()  # names that the text of the function assigns

    def _value(self, expression: ast.expr) -> Value:
        match expression:
            case ast.Name(id=name):
                return self._named(name)
            case ast.Constant(value=float(value)):
                return float_literal(value)
            case ast.Constant(value=int(value)) if not isinstance(value, bool):
                return integer_literal(value)
            case ast.Attribute(value=ast.Name(id="math"), attr="nan"):
                return float_literal(float("nan"))
            case ast.BinOp():
                return self._operations(expression)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self._negative(operand)
            case ast.Subscript():
                array, place = self._element(expression)
                return self.code.read(array, place)
            case ast.IfExp(test=test, body=body, orelse=other):
                return self._choice(test, body, other)
            case ast.Call(func=function, args=arguments, keywords=[]):
                return self._call(function, tuple(map(self._number, arguments)))
            case ast.Tuple(elts=elements):
                return Group(tuple(map(self._number, elements)))
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
                return self._truth(expression)
        raise UntranslatableError(ast.unparse(expression))

    def _number(self, expression: ast.expr) -> Number:
        return number_of(self._value(expression))

    def _integer(self, expression: ast.expr) -> Number:
        return self._as(INTEGER, self._number(expression))

    def _as(self, kind: str, number: Number) -> Number:
        """A number as one of a kind, if that loses nothing."""
        if number.kind == kind:
            return number
        if (kind, number.kind) != (FLOAT, INTEGER):
            raise UntranslatableError(f"{number.kind} in place of {kind}")
        return float_literal(int(number.text)) if is_literal(number) else self.code.as_float(number)

    def _named(self, name: str) -> Value:
        if name in self._variables:
            variable = self._variables[name]
            return replace(self.code.load(variable.text, variable.kind), unsigned=variable.unsigned)
        if name in self._values:
            return self._values[name]
        match None if name in self._locals else self.module.names.get(name):
            case np.ndarray() as table:
                return self.module.table(name, table)
            case float(value):
                return float_literal(value)
            case int(value) if not isinstance(value, bool):
                return integer_literal(value)
        raise UntranslatableError(name)

    def _operations(self, expression: ast.expr) -> Number:
        """A chain of operations from the left: a sum may have more terms than calls nest."""
        chain: list[ast.BinOp] = []
        while isinstance(expression, ast.BinOp):
            chain.append(expression)
            expression = expression.left
        number = self._number(expression)
        for operation in reversed(chain):
            number = self._calculation(operation.op, number, self._number(operation.right))
        return number

    def _calculation(self, op: ast.operator, a: Number, b: Number) -> Number:
        if a.unsigned and b.unsigned:
            raise UntranslatableError(f"{type(op).__name__} of two entries without sign")
        if isinstance(op, ast.FloorDiv):
            return self._floor_division(a, b)
        if isinstance(op, ast.Div):
            return self.code.calculation("fdiv", self._as(FLOAT, a), self._as(FLOAT, b))
        name = _BINARY.get(type(op), "")
        if name and a.kind == b.kind == INTEGER:
            return self.code.calculation(name if name == "and" else f"{name} nsw", a, b)
        if name in ("add", "sub", "mul"):
            return self.code.calculation(f"f{name}", self._as(FLOAT, a), self._as(FLOAT, b))
        raise UntranslatableError(f"{type(op).__name__} of {a} and {b}")

    def _floor_division(self, a: Number, b: Number) -> Number:
        if a.kind == FLOAT and b == float_literal(1.0):
            return self._floor(a)
        if a.kind == INTEGER and b == integer_literal(2):  # which rounds down
            return self.code.calculation("ashr", a, integer_literal(1))
        raise UntranslatableError(f"{a} // {b}")

    def _floor(self, a: Number) -> Number:
        """The next lower whole number, NaN of what is not finite, as in Python."""
        rounded = self._intrinsic("floor", a)
        finite = self.code.comparison("==", self.code.calculation("fsub", a, a), float_literal(0.0))
        return self.code.selection(finite, rounded, float_literal(float("nan")))

    def _negative(self, operand: ast.expr) -> Number:
        match operand:
            case ast.Constant(value=int(value) | float(value)):
                return self._number(ast.Constant(-value))
        number = signed(self._number(operand))
        if number.kind == FLOAT:
            return self.code.calculation("fsub", float_literal(-0.0), number)
        return self.code.calculation("sub", integer_literal(0), self._as(INTEGER, number))

    def _element(self, subscript: ast.Subscript) -> tuple[Array, Number]:
        array, index = self._value(subscript.value), subscript.slice
        places = index.elts if isinstance(index, ast.Tuple) else [index]
        if not isinstance(array, Array) or len(places) != len(array.shape):
            raise UntranslatableError(ast.unparse(subscript))
        numbers = map(self._integer, places)
        first, *others = map(self._from_the_beginning, numbers, array.shape)
        for length, other in zip(array.shape[1:], others, strict=True):
            row = self.code.calculation("mul", first, length)
            first = self.code.calculation("add", row, other)
        return array, first

    def _from_the_beginning(self, place: Number, length: Number) -> Number:
        """A place in an array, which counts from its end if it is negative."""
        if place.unsigned or (is_literal(place) and int(place.text) >= 0):
            return place
        from_end = self.code.calculation("add", place, length)
        negative = self.code.comparison("<", place, integer_literal(0))
        return self.code.selection(negative, from_end, place)

    def _choice(self, test: ast.expr, first: ast.expr, last: ast.expr) -> Number:
        code = self.code
        labels, behind = (code.label(), code.label()), code.label()
        self._branch(test, *labels)
        sides: list[tuple[Number, str]] = []
        for label, expression in zip(labels, (first, last), strict=True):
            code.begin(label)
            number = signed(self._number(expression))
            sides.append((number, code.block or ""))
            code.jump(behind)
        code.begin(behind)
        kinds = {number.kind for number, _ in sides}
        kind = kinds.pop() if len(kinds) == 1 else FLOAT
        if any(number.kind != kind and not is_literal(number) for number, _ in sides):
            raise UntranslatableError(f"{ast.unparse(first)} or {ast.unparse(last)}")
        return code.choice(kind, *((self._as(kind, number), end) for number, end in sides))

    def _branch(self, test: ast.expr, yes: str, no: str) -> None:
        """Go on at one of two labels; conditions are evaluated as far as they decide."""
        match test:
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                self._branch(operand, no, yes)
            case ast.BoolOp(op=op, values=[*operands, last]):
                for operand in operands:
                    further = self.code.label()
                    ways = (further, no) if isinstance(op, ast.And) else (yes, further)
                    self._branch(operand, *ways)
                    self.code.begin(further)
                self._branch(last, yes, no)
            case ast.Compare(ops=[_, _, _, *_]):
                raise UntranslatableError(ast.unparse(test))
            case ast.Compare(left=left, ops=[first, second], comparators=[middle, right]):
                number, further = self._number(middle), self.code.label()
                self.code.branch(self._relation(first, self._number(left), number), further, no)
                self.code.begin(further)
                self.code.branch(self._relation(second, number, self._number(right)), yes, no)
            case _:
                self.code.branch(self.code.truth(self._number(test)), yes, no)

    def _truth(self, test: ast.expr) -> Number:
        """A condition as a value."""
        code = self.code
        match test:
            case ast.Compare(left=left, ops=[sign], comparators=[right]):
                return self._relation(sign, self._number(left), self._number(right))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return code.calculation("xor", self._truth(operand), Number("true", TRUTH))
        labels, behind = (code.label(), code.label()), code.label()
        self._branch(test, *labels)
        for label in labels:
            code.begin(label)
            code.jump(behind)
        code.begin(behind)
        answers = (Number("true", TRUTH), Number("false", TRUTH))
        return code.choice(TRUTH, *zip(answers, labels, strict=True))

    def _relation(self, sign: ast.cmpop, a: Number, b: Number) -> Number:
        if type(sign) not in _SIGNS:
            raise UntranslatableError(type(sign).__name__)
        kind = INTEGER if a.kind == b.kind == INTEGER else FLOAT
        return self.code.comparison(_SIGNS[type(sign)], self._as(kind, a), self._as(kind, b))

    def _call(self, function: ast.expr, arguments: tuple[Number, ...]) -> Value:
        match function:
            case ast.Name(id=name) | ast.Attribute(value=ast.Name(id=name)) if name in self._locals:
                raise UntranslatableError(f"a call of {name}, which is assigned")
            case ast.Name(id="abs" | "float" as name) if name in self.module.names:
                raise UntranslatableError(f"another {name}")
            case ast.Name(id="abs") if [number.kind for number in arguments] == [FLOAT]:
                return self._intrinsic("fabs", *arguments)
            case ast.Name(id="float") if len(arguments) == 1:
                return self._as(FLOAT, arguments[0])
            case ast.Name(id=name) if hasattr(self.module.names.get(name), "py_func"):
                given = tuple(number.kind for number in arguments)
                declaration = self.module.declaration(name)
                if declaration is None:
                    arguments = tuple(map(signed, arguments))
                wanted, declared = declaration or (given, ())
                if len(wanted) != len(arguments):
                    raise UntranslatableError(f"{name} of {len(arguments)} arguments")
                arguments = tuple(map(self._as, wanted, arguments))
                symbol, results = self.module.callee(name, wanted, declared)
                if len(results) == 1:
                    return self.code.call(symbol, results[0], *arguments)
                structure = self.code.call(symbol, structure_of(results), *arguments)
                return self.code.unpacked(structure, results)
            case ast.Attribute(value=ast.Name(id="math"), attr="floor") if len(arguments) == 1:
                return self.code.as_integer(self._external("floor", *map(signed, arguments)))
            case ast.Attribute(value=ast.Name(id="numba"), attr="int64") if len(arguments) == 1:
                return replace(self._as(INTEGER, arguments[0]), unsigned=False)
            case ast.Attribute(value=ast.Name(id="math"), attr=name) if _INTRINSICS.get(
                name
            ) == len(arguments):
                return self._intrinsic(name, *arguments)
            case ast.Attribute(value=ast.Name(id="math"), attr=name) if _EXTERNALS.get(name) == len(
                arguments
            ):
                return self._external(name, *arguments)
        raise UntranslatableError(ast.unparse(function))

    def _intrinsic(self, name: str, *arguments: Number) -> Number:
        return self._elsewhere(f"llvm.{name}.f64", "", arguments)

    def _external(self, name: str, *arguments: Number) -> Number:
        return self._elsewhere(name, " readonly nounwind", arguments)

    def _elsewhere(self, function: str, effects: str, arguments: tuple[Number, ...]) -> Number:
        """A call of what this module does not define."""
        name = self.module.external(function, len(arguments), effects)
        return self.code.call(name, FLOAT, *(self._as(FLOAT, number) for number in arguments))


def number_of(value: Value) -> Number:
    """A value that is one number."""
    if not isinstance(value, Number):
        raise UntranslatableError(f"{type(value).__name__} in place of a number")
    return value


def signed(number: Number) -> Number:
    """The number; UntranslatableError if it is an entry without sign, of which numba differs."""
    if number.unsigned:
        raise UntranslatableError("an entry without sign")
    return number
