"""The expressions of a kernel's text → instructions of LLVM's.

The operations, their order and the licence to contract a product and a sum are those that numba
would take from the text.
"""

import ast
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]

if TYPE_CHECKING:
    from codegen.machine_code.kernel_translation import KernelModule

_ON_STACK = 1 << 16  # safety: bytes of an array there; threads have stacks of 512 kB and more
DOUBLE, INTEGER, POINTER = ir.DoubleType(), ir.IntType(64), ir.PointerType()
Number = Any  # a value of LLVM's, which leaves its names untyped
Value = Any  # a number, an array or a tuple of numbers

# Functions of `math` by the number of their arguments: LLVM's own, and those of the C library.
_INTRINSICS = {**dict.fromkeys(("sin", "cos", "exp", "log"), 1), "pow": 2}
_EXTERNALS = {
    **dict.fromkeys(("sqrt", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh"), 1), "atan2": 2,
}  # fmt: skip
_OPERATIONS: dict[type, str] = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
_SIGNS: dict[type, str] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip


class UntranslatableError(Exception):
    """A construct that generated kernels do not have."""

    def __init__(self, construct: ast.AST | str) -> None:
        super().__init__(construct if isinstance(construct, str) else ast.unparse(construct))


@dataclass(frozen=True)
class Array:
    """A contiguous array: the address of its first number, its kind, and its lengths."""

    address: Any
    kind: Any
    shape: tuple[Number, ...]


class ExpressionTranslation:
    """Evaluates expressions; UntranslatableError at what no kernel has.

    Attributes
    ----------
    module
        What the text knows besides the function's own names.
    """

    def __init__(self, module: "KernelModule", function: Any) -> None:
        self.module = module
        self._beginning = ir.IRBuilder(function.append_basic_block())  # room for what changes
        self._code = ir.IRBuilder(function.append_basic_block())
        self._values: dict[str, Value] = {}
        self._places: dict[str, tuple[Any, Any]] = {}  # name → address and kind
        self._locals: frozenset[str] = frozenset()  # names that the function assigns
        self._on_heap: list[Any] = []  # addresses of arrays that end with the function

    def _blocks(self, count: int) -> list[Any]:
        """New blocks, which stand where they begin: what is contracted depends on their order."""
        blocks = [self._code.append_basic_block() for _ in range(count)]
        del self._code.function.blocks[-count:]
        return blocks

    def _begin(self, block: Any) -> None:
        self._code.function.blocks.append(block)
        self._code.position_at_end(block)

    def _value(self, expression: ast.expr) -> Value:
        match expression:
            case ast.Name(id=name):
                return self._named(name)
            case ast.Constant(value=float(value)):
                return DOUBLE(value)
            case ast.Constant(value=int(value)) if not isinstance(value, bool) and value < 1 << 63:
                return INTEGER(value)
            case ast.Attribute(value=ast.Name(id="math"), attr="nan"):
                return DOUBLE(float("nan"))
            case ast.BinOp():
                return self._operations(expression)
            case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int(value) | float(value))):
                return self._value(ast.Constant(-value))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                negative = self._number(operand)
                if negative.type != DOUBLE:
                    raise UntranslatableError(expression)
                return self._code.fsub(DOUBLE(-0.0), negative, flags=self.module.flags)
            case ast.Subscript():
                array, address = self._element(expression)
                number = self._code.load(address, typ=array.kind)
                is_entry = array.kind.width == 32 if array.kind != DOUBLE else False
                return self._code.zext(number, INTEGER) if is_entry else number
            case ast.IfExp(test=test, body=body, orelse=other):
                return self._choice(test, body, other)
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
                return self._choice(expression, ast.Constant(1), ast.Constant(0))
            case ast.Call(func=function, args=arguments, keywords=[]):
                return self._call(function, [*map(self._number, arguments)])
            case ast.Tuple(elts=elements):
                return tuple(map(self._number, elements))
        raise UntranslatableError(expression)

    def _number(self, expression: ast.expr) -> Number:
        return number_of(self._value(expression))

    def _as(self, kind: Any, number: Number) -> Number:
        """A number as one of a kind, if that loses nothing."""
        if number.type == kind:
            return number
        if (kind, number.type) != (DOUBLE, INTEGER):
            raise UntranslatableError(f"{number.type} in place of {kind}")
        if isinstance(number, ir.Constant):
            return DOUBLE(float(number.constant))
        return self._code.sitofp(number, DOUBLE)

    def _named(self, name: str) -> Value:
        if name in self._places:
            address, kind = self._places[name]
            return self._code.load(address, typ=kind)
        if name in self._values:
            return self._values[name]
        match None if name in self._locals else self.module.names.get(name):
            case np.ndarray() as table:
                return self.module.table(name, table)
            case float(value):
                return DOUBLE(value)
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
        if _is_entry(a) and _is_entry(b):
            raise UntranslatableError(f"{type(op).__name__} of two entries without sign")
        code, flags = self._code, self.module.flags
        divisor = b.constant if isinstance(b, ir.Constant) else None
        whole = a.type == b.type == INTEGER
        match op:
            case ast.FloorDiv() if a.type == DOUBLE and divisor == 1:
                return self._floor(a)
            case ast.FloorDiv() if whole and divisor == 2:  # which rounds down
                return code.ashr(a, INTEGER(1))
            case ast.BitAnd() if whole:
                return code.and_(a, b)
            case ast.Add() | ast.Sub() | ast.Mult() if whole:
                return getattr(code, _OPERATIONS[type(op)])(a, b, flags=("nsw",))
            case ast.Add() | ast.Sub() | ast.Mult() | ast.Div():
                operation = getattr(code, f"f{_OPERATIONS.get(type(op), 'div')}")
                return operation(self._as(DOUBLE, a), self._as(DOUBLE, b), flags=flags)
        raise UntranslatableError(f"{type(op).__name__} of {a.type} and {b}")

    def _floor(self, a: Number) -> Number:
        """The next lower whole number, NaN of what is not finite, as in Python."""
        rounded = self._external("llvm.floor.f64", [a])
        difference = self._code.fsub(a, a, flags=self.module.flags)
        finite = self._relation(ast.Eq(), difference, DOUBLE(0.0))
        return self._code.select(finite, rounded, DOUBLE(float("nan")))

    def _element(self, subscript: ast.Subscript) -> tuple[Array, Any]:
        """The array, and the address of the element."""
        array, index, code = self._value(subscript.value), subscript.slice, self._code
        places = index.elts if isinstance(index, ast.Tuple) else [index]
        if not isinstance(array, Array) or len(places) != len(array.shape):
            raise UntranslatableError(subscript)
        numbers = (self._as(INTEGER, self._number(place)) for place in places)
        first, *others = map(self._from_the_beginning, numbers, array.shape)
        for length, other in zip(array.shape[1:], others, strict=True):
            first = code.add(code.mul(first, length), other)
        return array, code.gep(array.address, [first], source_etype=array.kind)

    def _from_the_beginning(self, place: Number, length: Number) -> Number:
        """A place in an array, which counts from its end if it is negative."""
        if _is_entry(place) or (isinstance(place, ir.Constant) and place.constant >= 0):
            return place
        from_end = self._code.add(place, length)
        negative = self._code.icmp_signed("<", place, INTEGER(0))
        return self._code.select(negative, from_end, place)

    def _choice(self, test: ast.expr, first: ast.expr, last: ast.expr) -> Number:
        code = self._code
        *blocks, behind = self._blocks(3)
        self._branch(test, *blocks)
        sides = []
        for block, expression in zip(blocks, (first, last), strict=True):
            self._begin(block)
            sides.append((signed(self._number(expression)), code.block))
            code.branch(behind)
        self._begin(behind)
        kinds = {number.type for number, _ in sides}
        kind = kinds.pop() if len(kinds) == 1 else DOUBLE
        chosen = code.phi(kind)
        for number, block in sides:
            if number.type != kind and not isinstance(number, ir.Constant):
                raise UntranslatableError(f"{ast.unparse(first)} or {ast.unparse(last)}")
            chosen.add_incoming(self._as(kind, number), block)
        return chosen

    def _branch(self, test: ast.expr, yes: Any, no: Any) -> None:
        """Go on in one of two blocks; conditions are evaluated as far as they decide."""
        code = self._code
        match test:
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                self._branch(operand, no, yes)
            case ast.BoolOp(op=op, values=[*operands, last]):
                for operand in operands:
                    (further,) = self._blocks(1)
                    ways = (further, no) if isinstance(op, ast.And) else (yes, further)
                    self._branch(operand, *ways)
                    self._begin(further)
                self._branch(last, yes, no)
            case ast.Compare(left=left, ops=[sign], comparators=[right]):
                code.cbranch(self._relation(sign, self._number(left), self._number(right)), yes, no)
            case ast.Compare(left=left, ops=[first, second], comparators=[middle, right]):
                number, (further,) = self._number(middle), self._blocks(1)
                code.cbranch(self._relation(first, self._number(left), number), further, no)
                self._begin(further)
                code.cbranch(self._relation(second, number, self._number(right)), yes, no)
            case _:
                number = self._number(test)
                code.cbranch(self._relation(ast.NotEq(), number, number.type(0)), yes, no)

    def _relation(self, sign: ast.cmpop, a: Number, b: Number) -> Number:
        """Whether a relation holds; nothing but != holds for what is no number."""
        if type(sign) not in _SIGNS:
            raise UntranslatableError(type(sign).__name__)
        symbol = _SIGNS[type(sign)]
        if a.type == b.type == INTEGER:
            return self._code.icmp_signed(symbol, a, b)
        compare = self._code.fcmp_unordered if symbol == "!=" else self._code.fcmp_ordered
        return compare(symbol, self._as(DOUBLE, a), self._as(DOUBLE, b), flags=self.module.flags)

    def _call(self, function: ast.expr, arguments: list[Number]) -> Value:
        match function:
            case ast.Name(id=name) | ast.Attribute(value=ast.Name(id=name)) if name in self._locals:
                raise UntranslatableError(f"a call of {name}, which is assigned")
            case ast.Name(id=name) if name in self.module.names:
                return self._call_of_function(name, arguments)
            case ast.Name(id="abs") if [number.type for number in arguments] == [DOUBLE]:
                return self._external("llvm.fabs.f64", arguments)
            case ast.Name(id="int") if [number.type for number in arguments] == [DOUBLE]:
                return self._code.fptosi(arguments[0], INTEGER)
            case ast.Name(id="float") if len(arguments) == 1:
                return self._as(DOUBLE, arguments[0])
            case ast.Attribute(value=ast.Name(id="math"), attr="floor") if len(arguments) == 1:
                rounded = self._external("floor", [*map(signed, arguments)])
                return self._code.fptosi(rounded, INTEGER)
            case ast.Attribute(value=ast.Name(id="np"), attr="empty") if len(arguments) == 1:
                return self._array(arguments[0])
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                if _INTRINSICS.get(name) == len(arguments):
                    return self._external(f"llvm.{name}.f64", arguments)
                if _EXTERNALS.get(name) == len(arguments):
                    return self._external(name, arguments)
        raise UntranslatableError(function)

    def _array(self, length: Number) -> Array:
        """An array of the function's own, of floating-point numbers.

        Its address is hidden from the optimizer. With arrays of which it knows that no others
        overlap them it keeps more values in registers than there are, a tenth slower.
        """
        if not isinstance(length, ir.Constant) or length.type != INTEGER:
            raise UntranslatableError(f"an array of {length}")
        code, size = self._beginning, 8 * length.constant
        if size <= _ON_STACK:
            address = code.bitcast(code.alloca(DOUBLE, length), POINTER)
        else:
            allocate = self.module.function("malloc", POINTER, INTEGER)
            address = code.call(allocate, [INTEGER(size)])
            self._on_heap.append(address)
        same = ir.FunctionType(POINTER, [POINTER])
        return Array(code.asm(same, "", "=r,0", [address], False), DOUBLE, (length,))

    def _call_of_function(self, name: str, arguments: list[Number]) -> Value:
        """What a function of the text returns."""
        function, kinds, results = self.module.callee(name, [number.type for number in arguments])
        if len(kinds) != len(arguments):
            raise UntranslatableError(f"{name} of {len(arguments)} arguments")
        given = [self._as(kind, signed(x)) for kind, x in zip(kinds, arguments, strict=True)]
        flags = self.module.flags if len(results) == 1 and results[0] == DOUBLE else ()
        returned = self._code.call(function, given, fastmath=flags)
        if len(results) == 1:
            return returned
        return tuple(self._code.extract_value(returned, place) for place in range(len(results)))

    def _external(self, name: str, arguments: list[Number]) -> Number:
        """What a function elsewhere returns, of floating-point numbers."""
        function = self.module.external(name, len(arguments))
        numbers = [self._as(DOUBLE, number) for number in arguments]
        return self._code.call(function, numbers, fastmath=self.module.flags)


def number_of(value: Value) -> Number:
    """A value that is one number."""
    if not isinstance(value, ir.Value):
        raise UntranslatableError(f"{type(value).__name__} in place of a number")
    return value


def _is_entry(number: Number) -> bool:
    """Whether it is an entry of a table without sign, with which numba may calculate otherwise."""
    return getattr(number, "opname", "") == "zext"


def signed(number: Number) -> Number:
    """The number; UntranslatableError if it is an entry without sign, of which numba differs."""
    if _is_entry(number):
        raise UntranslatableError("an entry without sign")
    return number
