"""Vector lanes for Numba: one value per element of a block, held in one register.

The functions of this file take a `lane`. With an integer they work on that element of a block, as
plain Numba (or Python) does. With `None` they work on the whole block: values are of the type
`Lanes`, LLVM's ``<n x float>``, and arithmetic on them is vector code on any processor. So one
text of a kernel is both the fast version and its scalar twin.
"""

import math
import operator
from functools import partial
from typing import Any

import numba
import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.core.datamodel import models
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_cast, overload, register_model
from numba.np.arrayobj import make_array

from softsample.constitutive.functions import exp, expm1, growth, lesser, log, positive

_BYTES = 64 if binding.get_host_cpu_features().get("avx512f") else 32

LANES = {kind: _BYTES // kind.itemsize for kind in map(np.dtype, (np.float32, np.float64))}
"""Elements per block: one register of the processor, of 512 or 256 bits. With blocks of two
registers the values of an element do not fit into all of them (a fifth slower)."""

FUSED = ("contract",)
"""Let the compiler fuse multiplication and addition, nothing else."""

_OPTIONS = {"error_model": "numpy", "_nrt": False}
# Without reference counting of arrays (`_nrt`), which halves the speed of these loops.

_PART = {**_OPTIONS, "forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# What only compiled code calls needs no entry for Python: a third of the time to compile.

compiled, inline = numba.njit(cache=True, **_OPTIONS), numba.njit(**_PART)
"""Decorators of a kernel that Python calls and of its parts, which Python must not call. A cached
kernel does not notice an edit of a part in another file: tests, make and the workflow keep one
cache for each state of the sources (`softsample.dependencies.state_of_kernels`)."""

_overload_part = partial(overload, jit_options=_PART)


class Lanes(types.Type):
    """`count` numbers of type `dtype` in one LLVM vector."""

    def __init__(self, dtype: types.Float) -> None:
        self.dtype = dtype
        self.count = LANES[np.dtype(str(dtype))]
        super().__init__(name=f"Lanes({dtype} x {self.count})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Lanes) -> None:
        element = manager.lookup(kind.dtype).get_value_type()
        super().__init__(manager, kind, ir.VectorType(element, kind.count))


def _indices(values):
    """Constant vector of int32."""
    return ir.Constant(ir.VectorType(ir.IntType(32), len(values)), list(values))


def _splat(builder, scalar, count):
    """Repeat a scalar in all lanes."""
    undefined = ir.Constant(ir.VectorType(scalar.type, count), ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, undefined, _indices([0] * count))


@lower_cast(types.Float, Lanes)
@lower_cast(types.Integer, Lanes)
def _cast_scalar(context, builder, source, target, value):
    return _splat(builder, context.cast(builder, value, source, target.dtype), target.count)


def _teach(function, instruction):
    """Let Numba apply a binary operator to lanes, and to lanes and scalars."""

    @infer_global(function)
    class _Operator(AbstractTemplate):
        def generic(self, args, keywords):
            lanes = [kind for kind in args if isinstance(kind, Lanes)]
            if lanes and all(isinstance(kind, (Lanes, types.Number)) for kind in args):
                return signature(lanes[0], lanes[0], lanes[0])
            return None

    @lower_builtin(function, Lanes, Lanes)
    def _lower(context, builder, sig, args):
        return getattr(builder, instruction)(*args, flags=FUSED)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _teach(_function, _instruction)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args, keywords):
        return signature(args[0], args[0]) if isinstance(args[0], Lanes) else None


@lower_builtin(operator.neg, Lanes)
def _lower_negative(context, builder, sig, args):
    return builder.fneg(args[0])


# --- memory -------------------------------------------------------------------------------------


def _pointer(context, builder, kind, array, index_kind, index):
    """Pointer to array[index + (0, 0, ...)] of a C-contiguous array."""
    struct = make_array(kind)(context, builder, array)
    lengths = [builder.extract_value(struct.shape, axis) for axis in range(kind.ndim)]
    offset = ir.Constant(lengths[0].type, 0)
    for axis, length in enumerate(lengths):
        offset = builder.mul(offset, length)
        if axis < len(index_kind):
            part = builder.extract_value(index, axis)
            part = context.cast(builder, part, index_kind[axis], types.intp)
            offset = builder.add(offset, part)
    return builder.gep(struct.data, [offset])


def _vector_pointer(context, builder, array_kind, array, index_kind, index, count):
    pointer = _pointer(context, builder, array_kind, array, index_kind, index)
    element = context.get_data_type(array_kind.dtype)
    return builder.bitcast(pointer, ir.VectorType(element, count).as_pointer())


@intrinsic
def _load_lanes(typing_context, array, index):
    lanes = Lanes(array.dtype)

    def codegen(context, builder, sig, args):
        pointer = _vector_pointer(context, builder, array, args[0], index, args[1], lanes.count)
        return builder.load(pointer, align=array.dtype.bitwidth // 8)

    return lanes(array, index), codegen


@intrinsic
def _store_lanes(typing_context, array, index, value):
    def codegen(context, builder, sig, args):
        pointer = _vector_pointer(context, builder, array, args[0], index, args[1], value.count)
        builder.store(args[2], pointer, align=array.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, index, value), codegen


def _rows(context, builder, array_kind, array, nodes_kind, nodes, index_kind, index, count, step):
    """Pointers to the rows of four that the nodes of a block occupy, `step` rows each."""
    first = _pointer(context, builder, nodes_kind, nodes, index_kind, index)
    number = context.get_data_type(array_kind.dtype)
    base = make_array(array_kind)(context, builder, array).data
    for lane in range(0, count, step):
        node = builder.load(builder.gep(first, [ir.Constant(ir.IntType(64), lane)]))
        start = builder.mul(builder.sext(node, ir.IntType(64)), ir.Constant(ir.IntType(64), 4))
        pointer = builder.gep(base, [start])
        yield builder.bitcast(pointer, ir.VectorType(number, 4 * step).as_pointer())


def _shuffle(builder, first, second, indices):
    return builder.shuffle_vector(first, second, _indices(indices))


def _gather_by(step_of):
    """Intrinsic that loads `step_of(n)` rows at a time and transposes them in registers."""

    def columns(builder, first, second, i):
        """Columns i and i + 1 of two registers of n/4 rows each, one after the other."""
        n = first.type.count
        column = [[4 * k + c for k in range(n // 4)] for c in (i, i + 1)]
        order = [k + side for c in column for side in (0, n) for k in c]
        return _shuffle(builder, first, second, order)

    @intrinsic
    def gather_lanes(typing_context, array, nodes, index):
        lanes = Lanes(array.dtype)
        n = lanes.count

        def codegen(context, builder, sig, args):
            align = array.dtype.bitwidth // 8
            rows = _rows(
                context, builder, array, args[0], nodes, args[1], index, args[2], n, step_of(n)
            )
            parts = [builder.load(pointer, align=align) for pointer in rows]
            while len(parts) > 4:
                both = range(2 * parts[0].type.count)
                parts = [
                    _shuffle(builder, parts[k], parts[k + 1], both) for k in range(0, len(parts), 2)
                ]
            low, high = range(n // 2), range(n // 2, n)
            components = []
            for i, halves in ((0, (low, high)), (2, (low,))):
                first = columns(builder, parts[0], parts[1], i)
                second = columns(builder, parts[2], parts[3], i)
                for half in halves:
                    order = [*half, *(n + k for k in half)]
                    components.append(_shuffle(builder, first, second, order))
            return context.make_tuple(builder, sig.return_type, components)

        return types.UniTuple(lanes, 3)(array, nodes, index), codegen

    return gather_lanes


def _scatter_by(step_of):
    """Intrinsic that transposes back to rows, then adds `step_of(n)` of them at a time."""

    def interleaved(builder, first, second, start, width):
        """Groups of `width` numbers of two registers by turns, from `start` on, n in all."""
        n = first.type.count
        groups = range(start, start + n // 2, width)
        order = [k + i + side for k in groups for side in (0, n) for i in range(width)]
        return _shuffle(builder, first, second, order)

    @intrinsic
    def scatter_lanes(typing_context, array, nodes, index, x, y, z):
        n = Lanes(array.dtype).count

        def codegen(context, builder, sig, args):
            x, y, z = args[3:]
            zero = ir.Constant(z.type, [ir.Constant(z.type.element, 0.0)] * n)
            parts = []
            for half in (0, n // 2):
                xy = interleaved(builder, x, y, half, 1)
                zw = interleaved(builder, z, zero, half, 1)
                parts += [interleaved(builder, xy, zw, start, 2) for start in (0, n // 2)]
            align, width = array.dtype.bitwidth // 8, 4 * step_of(n)
            rows = _rows(
                context, builder, array, args[0], nodes, args[1], index, args[2], n, step_of(n)
            )
            for k, pointer in enumerate(rows):
                part, first = parts[width * k // n], width * k % n
                row = _shuffle(builder, part, part, range(first, first + width))
                total = builder.fadd(builder.load(pointer, align=align), row)
                builder.store(total, pointer, align=align)
            return context.get_dummy_value()

        return types.void(array, nodes, index, x, y, z), codegen

    return scatter_lanes


def group(count: int) -> int:
    """Rows of four numbers in a register of `count`."""
    return count // 4


_gather_rows, _scatter_rows = _gather_by(lambda n: 1), _scatter_by(lambda n: 1)
_gather_groups, _scatter_groups = _gather_by(group), _scatter_by(group)


def load(array, index, lane):
    """``array[*index, lane]``, or the whole block if `lane` is None."""
    return array[index + (lane,)]


def store(array, index, lane, value):
    """``array[*index, lane] = value``, or of the whole block if `lane` is None."""
    array[index + (lane,)] = value


def gather(array, nodes, index, lane, grouped):
    """First three entries of the row ``nodes[*index, lane]`` of a nodal array (n_nodes, 4).

    `grouped` says of a block that the nodes of each `group` of its lanes follow one another, so
    that whole registers can be loaded.
    """
    node = nodes[index + (lane,)]
    return array[node, 0], array[node, 1], array[node, 2]


def scatter_add(array, nodes, index, lane, grouped, x, y, z):
    """Add to that row; rows or groups one after the other, so that shared nodes come right."""
    node = nodes[index + (lane,)]
    array[node, 0] += x
    array[node, 1] += y
    array[node, 2] += z


@_overload_part(load)
def _load(array, index, lane):
    if isinstance(lane, types.NoneType):
        return lambda array, index, lane: _load_lanes(array, index)
    return load


@_overload_part(store)
def _store(array, index, lane, value):
    if isinstance(lane, types.NoneType):
        return lambda array, index, lane, value: _store_lanes(array, index, value)
    return store


@_overload_part(gather)
def _gather(array, nodes, index, lane, grouped):
    if isinstance(lane, types.NoneType):

        def vector(array, nodes, index, lane, grouped):
            if grouped:
                return _gather_groups(array, nodes, index)
            return _gather_rows(array, nodes, index)

        return vector
    return gather


@_overload_part(scatter_add)
def _scatter_add(array, nodes, index, lane, grouped, x, y, z):
    if isinstance(lane, types.NoneType):

        def vector(array, nodes, index, lane, grouped, x, y, z):
            if grouped:
                _scatter_groups(array, nodes, index, x, y, z)
            else:
                _scatter_rows(array, nodes, index, x, y, z)

        return vector
    return scatter_add


# --- functions ----------------------------------------------------------------------------------


def like(x, value):
    """`value` as a number of the type of `x`."""
    return type(x)(value)


def copysign(x, y):
    """|x| with the sign of y."""
    return math.copysign(x, y)


def reciprocal_sqrt(x):
    """1 / sqrt(x) of x > 0."""
    return 1.0 / math.sqrt(x)


class _Code:
    """Code generation on lanes: constants, arithmetic and reinterpretation."""

    def __init__(self, builder: ir.IRBuilder, lanes: Lanes) -> None:
        self.builder, self.double = builder, lanes.dtype.bitwidth == 64
        self.vector = ir.VectorType(ir.DoubleType() if self.double else ir.FloatType(), lanes.count)
        self.integers = ir.VectorType(ir.IntType(lanes.dtype.bitwidth), lanes.count)
        self.mantissa_bits, self.bias = (52, 1023) if self.double else (23, 127)

    def number(self, value):
        return ir.Constant(
            self.vector, [ir.Constant(self.vector.element, value)] * self.vector.count
        )

    def integer(self, value):
        return ir.Constant(self.integers, [value] * self.vector.count)

    def bits(self, x):
        return self.builder.bitcast(x, self.integers)

    def from_bits(self, i):
        return self.builder.bitcast(i, self.vector)

    def call(self, name, *args):
        """An intrinsic of LLVM, by its name without the type."""
        kind = ir.FunctionType(self.vector, [self.vector] * len(args))
        name += f".v{self.vector.count}f{64 if self.double else 32}"
        return self.builder.call(get_or_insert_function(self.builder.module, kind, name), args)

    def multiply_add(self, x, y, z):
        return self.builder.fadd(self.builder.fmul(x, y, flags=FUSED), z, flags=FUSED)

    def polynomial(self, x, coefficients):
        """Horner's rule, highest power first."""
        value = self.number(coefficients[0])
        for c in coefficients[1:]:
            value = self.multiply_add(value, x, self.number(c))
        return value


def _reciprocal_sqrt_code(code, x):
    """Newton's iteration from the usual guess by halving the exponent: no root, no division."""
    b = code.builder
    magic = 0x5FE6EB50C7B537A9 if code.double else 0x5F375A86
    guess = b.sub(code.integer(magic), b.lshr(code.bits(x), code.integer(1)))
    y, half = code.from_bits(guess), b.fmul(x, code.number(-0.5))
    for _ in range(4 if code.double else 3):
        y = b.fmul(y, code.multiply_add(b.fmul(half, y), y, code.number(1.5)))
    return y


def _exp_parts(code, x):
    """x = k ln 2 + r: r, |r| < 0.35, and 2^k."""
    b = code.builder
    reach = 0.69 * code.bias
    x = code.call(
        "llvm.minnum", code.call("llvm.maxnum", x, code.number(-reach)), code.number(reach)
    )
    k = code.call("llvm.rint", b.fmul(x, code.number(1.0 / math.log(2.0))))
    high = 0.693359375  # ln 2 = high + low; k * high is exact
    r = code.multiply_add(k, code.number(-high), x)
    r = code.multiply_add(k, code.number(high - math.log(2.0)), r)
    exponent = b.add(b.fptosi(k, code.integers), code.integer(code.bias))
    return r, code.from_bits(b.shl(exponent, code.integer(code.mantissa_bits)))


def _taylor(code, r, lowest):
    """Taylor series of exp(r) over r^lowest, from that power on."""
    degree = 13 if code.double else 7
    return code.polynomial(r, [1.0 / math.factorial(n) for n in range(degree, lowest - 1, -1)])


def _exp_code(code, x):
    """Taylor series of exp(r), then the exponent k."""
    r, scale = _exp_parts(code, x)
    return code.builder.fmul(_taylor(code, r, 0), scale)


def _expm1_code(code, x):
    """2^k (exp(r) - 1) + (2^k - 1), the first a series without its one."""
    r, scale = _exp_parts(code, x)
    less = code.builder.fmul(r, _taylor(code, r, 1))
    return code.multiply_add(less, scale, code.builder.fsub(scale, code.number(1.0)))


def _positive_code(code, x):
    half = code.number(0.5)
    return code.builder.fadd(half, code.call("llvm.copysign", half, x))


def _log_code(code, x):
    """x = 2^k m, 0.7 < m < 1.42; log m = 2 artanh s with s = (m - 1) / (m + 1), as a series."""
    b = code.builder
    root = code.bits(code.number(math.sqrt(0.5)))
    k = b.ashr(b.sub(code.bits(x), root), code.integer(code.mantissa_bits))
    m = code.from_bits(b.sub(code.bits(x), b.shl(k, code.integer(code.mantissa_bits))))
    s = b.fdiv(b.fsub(m, code.number(1.0)), b.fadd(m, code.number(1.0)))
    highest = 21 if code.double else 9
    series = code.polynomial(b.fmul(s, s), [2.0 / n for n in range(highest, 0, -2)])
    return code.multiply_add(
        b.sitofp(k, code.vector), code.number(math.log(2.0)), b.fmul(s, series)
    )


def _overload(function, generate, scalar=None):
    """Overload a function of numbers by code on lanes, and on numbers by itself or by `scalar`."""
    unary, plain = function.__code__.co_argcount == 1, scalar or function

    @intrinsic
    def one(typing_context, x):
        def codegen(context, builder, sig, args):
            return generate(_Code(builder, x), *args)

        return x(x), codegen

    @intrinsic
    def two(typing_context, x, y):
        def codegen(context, builder, sig, args):
            return generate(_Code(builder, x), *args)

        return x(x, x), codegen

    if unary:

        @_overload_part(function)
        def choose_one(x):
            return (lambda x: one(x)) if isinstance(x, Lanes) else plain
    else:

        @_overload_part(function)
        def choose_two(x, y):
            return (lambda x, y: two(x, y)) if isinstance(x, Lanes) else plain


_overload(copysign, lambda code, x, y: code.call("llvm.copysign", x, y))
_overload(reciprocal_sqrt, _reciprocal_sqrt_code)
_overload(exp, _exp_code)
_overload(expm1, _expm1_code)
_overload(log, _log_code)
_overload(lesser, lambda code, x, y: code.call("llvm.minnum", x, y), lambda x, y: x if x < y else y)
_overload(positive, _positive_code, lambda x: 1.0 if x > 0.0 else 0.0)
_overload_part(growth)(lambda x: growth)


@intrinsic
def _like_lanes(typing_context, x, value):
    return x(x, x), lambda context, builder, sig, args: args[1]


@_overload_part(like)
def _like(x, value):
    if isinstance(x, Lanes):
        return lambda x, value: _like_lanes(x, value)
    kind = x
    return lambda x, value: kind(value)
