"""Eight numbers at a time, for what the pivots of ray shooting spend their time on.

Loops over six numbers become vector code by chance at best; these few functions are vector code
on every processor, as LLVM cuts eight lanes into what it has. They work on flat arrays of rows of
eight, of which a basis of six takes six lanes and leaves the others 0. Vectors are six-tuples.
"""

from __future__ import annotations

import functools
import platform
from typing import Any

from llvmlite import ir
from llvmlite.binding import get_host_cpu_features
from numba import extending, types
from numba.core import cgutils

WIDE = 8
WORD, SHORT = ir.IntType(64), ir.IntType(32)
ROW, WORDS = ir.VectorType(ir.DoubleType(), WIDE), ir.VectorType(WORD, WIDE)
LANES = ir.Constant(WORDS, list(range(WIDE)))
FLAT, SIX = types.Array(types.float64, 1, "C"), types.UniTuple(types.float64, 6)
# Where the processor has no fused multiply-add, asking for it would call a slow function. Left to
# LLVM, two entries that compile the same function could round differently.
FUSED = platform.machine().lower() in ("arm64", "aarch64") or bool(
    get_host_cpu_features().get("fma")
)
# A column entry of less is no place to leave from; ratios this close are a tie.
LEAST, TIE = 1e-11, 1e-13
# Untyped, as what it makes is called with fewer arguments than it is written with.
intrinsic: Any = extending.intrinsic


def _at(context: Any, b: Any, array: Any, row: Any) -> Any:
    """Pointer to a row of a flat array."""
    data = context.make_array(FLAT)(context, b, array).data
    return b.bitcast(b.gep(data, [b.mul(row, WORD(WIDE))], inbounds=True), ROW.as_pointer())


def _load(context: Any, b: Any, array: Any, row: Any) -> Any:
    value = b.load(_at(context, b, array, row))
    value.align = 8
    return value


def _all(b: Any, number: Any, kind: Any = ROW) -> Any:
    """The number in every lane."""
    nothing = ir.Constant(kind, ir.Undefined)
    first = b.insert_element(nothing, number, SHORT(0))
    return b.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(SHORT, WIDE), [0] * WIDE))


def _add(b: Any, total: Any, factor: Any, row: Any) -> Any:
    """``total`` and the product."""
    if not FUSED:
        return b.fadd(total, b.fmul(factor, row))
    fused = cgutils.get_or_insert_function(
        b.module, ir.FunctionType(ROW, [ROW, ROW, ROW]), "llvm.fma.v8f64"
    )
    return b.call(fused, [factor, row, total])


def _sum(context: Any, b: Any, array: Any, first: Any, factors: Any) -> Any:
    """Sum of six rows from ``first`` on, times their factors."""
    total = None
    for k, factor in enumerate(cgutils.unpack_tuple(b, factors, 6)):
        row = _load(context, b, array, b.add(first, WORD(k)))
        every = _all(b, factor)
        total = b.fmul(every, row) if total is None else _add(b, total, every, row)
    return total


def _extreme(b: Any, row: Any, order: str) -> Any:
    """The largest (">") or smallest ("<") of the lanes."""
    half = WIDE // 2
    while half:
        kind = ir.VectorType(SHORT, half)
        low = b.shuffle_vector(row, row, ir.Constant(kind, list(range(half))))
        high = b.shuffle_vector(row, row, ir.Constant(kind, list(range(half, 2 * half))))
        row = b.select(b.fcmp_ordered(order, low, high), low, high)
        half //= 2
    return b.extract_element(row, SHORT(0))


@intrinsic
def product(_: Any, rows: Any, to: Any, first: Any, factors: Any) -> Any:
    """Write the sum of six rows from ``first`` on, times their factors, to row ``to``."""

    def code(context: Any, b: Any, signature: Any, given: Any) -> Any:
        rows, to, first, factors = given
        b.store(_sum(context, b, rows, first, factors), _at(context, b, rows, to), align=8)
        return context.get_dummy_value()

    return types.void(FLAT, types.int64, types.int64, SIX), code


@intrinsic
def sweep(_: Any, rows: Any, to: Any, source: Any, factor: Any, lane: Any) -> Any:
    """Take ``factor`` times row ``source`` from row ``to``; at ``lane`` put the factor itself."""

    def code(context: Any, b: Any, signature: Any, given: Any) -> Any:
        rows, to, source, factor, lane = given
        every = _all(b, factor)
        before, row = _load(context, b, rows, to), _load(context, b, rows, source)
        left = _add(b, before, b.fneg(every), row)
        here = b.icmp_signed("==", _all(b, lane, WORDS), LANES)
        b.store(b.select(here, every, left), _at(context, b, rows, to), align=8)
        return context.get_dummy_value()

    return types.void(FLAT, types.int64, types.int64, types.float64, types.int64), code


@intrinsic
def best_lane(_: Any, rows: Any, first: Any, blocks: Any, floor: Any, u: Any) -> Any:
    """Number of the column most along u; -1 when none is above ``floor``.

    The columns come in blocks of eight, each as six rows, from row ``first`` on.
    """

    def code(context: Any, b: Any, signature: Any, given: Any) -> Any:
        rows, first, blocks, floor, u = given
        best, names = cgutils.alloca_once(b, ROW), cgutils.alloca_once(b, WORDS)
        b.store(_all(b, floor), best)
        b.store(ir.Constant(WORDS, [-1] * WIDE), names)
        with cgutils.for_range(b, blocks) as loop:
            row = b.add(first, b.mul(loop.index, WORD(6)))
            value, before = _sum(context, b, rows, row, u), b.load(best)
            more = b.fcmp_ordered(">", value, before)
            name = b.or_(_all(b, b.mul(loop.index, WORD(WIDE)), WORDS), LANES)
            b.store(b.select(more, value, before), best)
            b.store(b.select(more, name, b.load(names)), names)
        values = b.load(best)
        top = b.fcmp_ordered("==", values, _all(b, _extreme(b, values, ">")))
        lane = b.cttz(b.bitcast(top, ir.IntType(WIDE)), ir.IntType(1)(0))
        return b.extract_element(b.load(names), b.zext(lane, SHORT))

    return types.int64(FLAT, types.int64, types.int64, types.float64, SIX), code


@intrinsic
def leaving(_: Any, rows: Any, column: Any, weight: Any) -> Any:
    """Lane of the smallest ratio of the two rows, the larger column entry of equals; -1 if none."""

    def code(context: Any, b: Any, signature: Any, given: Any) -> Any:
        rows, column, weight = given
        column, weight = _load(context, b, rows, column), _load(context, b, rows, weight)
        zero, far = ir.Constant(ROW, [0.0] * WIDE), ir.Constant(ROW, [float("inf")] * WIDE)
        able = b.fcmp_ordered(">", column, ir.Constant(ROW, [LEAST] * WIDE))
        weight = b.select(b.fcmp_ordered(">", weight, zero), weight, zero)
        ratio = b.select(able, b.fdiv(weight, column), far)
        limit = b.fmul(_extreme(b, ratio, "<"), ir.DoubleType()(1.0 + TIE))
        tied = b.and_(able, b.fcmp_ordered("<=", ratio, _all(b, limit)))
        # The lane's number takes the place of the last bits, so that the largest brings its own.
        entry = b.bitcast(b.select(tied, column, zero), WORDS)
        entry = b.or_(b.and_(entry, ir.Constant(WORDS, [-WIDE] * WIDE)), LANES)
        found = b.bitcast(_extreme(b, b.bitcast(entry, ROW), ">"), WORD)
        none = b.icmp_signed("<", found, WORD(WIDE))
        return b.select(none, WORD(-1), b.and_(found, WORD(WIDE - 1)))

    return types.int64(FLAT, types.int64, types.int64), code


@intrinsic
def off_identity(_: Any, rows: Any, first: Any) -> Any:
    """By how much six rows from ``first`` on differ from the identity, all entries together."""

    def code(context: Any, b: Any, signature: Any, given: Any) -> Any:
        rows, first = given
        total: Any = ir.Constant(ROW, [0.0] * WIDE)
        for k in range(6):
            unit = ir.Constant(ROW, [float(k == lane) for lane in range(WIDE)])
            off = b.fsub(_load(context, b, rows, b.add(first, WORD(k))), unit)
            back = b.fneg(off)
            total = b.fadd(total, b.select(b.fcmp_ordered(">", off, back), off, back))
        # A sum and not the largest, which would lose an entry that is no number.
        return functools.reduce(b.fadd, [b.extract_element(total, SHORT(k)) for k in range(6)])

    return types.float64(FLAT, types.int64), code
