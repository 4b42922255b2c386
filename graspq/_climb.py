"""Compiled pivots of ray shooting on plain polytopes: what ``_pivot.primal`` does, faster.

u and the weights are updated with every pivot instead of formed anew. Where contacts have many
columns, those that ever were the best of theirs are asked first, and all only when these few
have nothing left to gain.
"""

from __future__ import annotations

import numpy as np

from graspq._jit import compiled
from graspq._oracle import FAST, invert

MANY, SLOTS = 256, 64
GAIN = 1e-7


@compiled(fastmath=FAST)
def scores(u, points, first, last, out):
    """out = u · points over the columns first to last."""
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    for k in range(first, last):
        out[k] = (u0 * points[0, k] + u1 * points[1, k] + u2 * points[2, k]
                  + u3 * points[3, k] + u4 * points[4, k] + u5 * points[5, k])


@compiled(fastmath=FAST)
def _top(score, first, last):
    best = score[first]
    for k in range(first + 1, last):
        best = score[k] if score[k] > best else best
    return best


@compiled
def best_of(u, points, starts, zero, score, choice):
    """Write every contact's best column (-1 for the origin) and return the sum of their values."""
    scores(u, points, 0, points.shape[1], score)
    total = 0.0
    for i in range(starts.shape[0] - 1):
        first, last = starts[i], starts[i + 1]
        if last - first > 32:
            best = _top(score, first, last)
            pick = first
            while score[pick] != best:
                pick += 1
        else:
            best, pick = score[first], first
            for k in range(first + 1, last):
                if score[k] > best:
                    best, pick = score[k], k
        if zero and not best > 0.0:
            best, pick = 0.0, -1
        total += best
        choice[i] = pick
    return total


@compiled
def _short_best(u, few, names, counts, zero, score, choice):
    """``best_of`` among the columns that were the best before."""
    total = 0.0
    for i in range(counts.shape[0]):
        first = i * SLOTS
        last = first + counts[i]
        scores(u, few, first, last, score)
        best, pick = -np.inf, -1
        for k in range(first, last):
            if score[k] > best:
                best, pick = score[k], names[k]
        if zero and not best > 0.0:
            best, pick = 0.0, -1
        total += best
        choice[i] = pick
    return total


@compiled
def new_list(columns, bodies):
    """Scratch for the columns that were the best of their contact: (few, names, counts, score)."""
    wide = bodies * SLOTS if columns > MANY else 0
    return (np.empty((6, wide)), np.empty(wide, np.int64), np.zeros(bodies, np.int64),
            np.empty(wide))


@compiled
def _remember(points, choice, short):
    """Add the chosen columns to the list; False when nothing was new or it is full."""
    few, names, counts, _ = short
    grown = False
    for i in range(counts.shape[0]):
        pick = choice[i]
        if pick < 0 or counts[i] == SLOTS:
            continue
        known = False
        for k in range(i * SLOTS, i * SLOTS + counts[i]):
            known = known or names[k] == pick
        if not known:
            at = i * SLOTS + counts[i]
            for r in range(6):
                few[r, at] = points[r, pick]
            names[at] = pick
            counts[i] += 1
            grown = True
    return grown


@compiled
def ask(u, body, enough, score, choice, short, out):
    """Support value of u and its vertex; a vertex worth more than ``enough`` will do."""
    points, starts, zero, shift = body[0], body[1], body[5], body[6]
    few, names, counts, few_score = short
    wide = few.shape[1] > 0
    away, h = 0.0, -np.inf
    for r in range(6):
        away += u[r] * shift[r]
    if wide and counts.max() > 0:
        h = _short_best(u, few, names, counts, zero, few_score, choice) - away
    if h <= enough:
        h = best_of(u, points, starts, zero, score, choice) - away
        if wide:
            _remember(points, choice, short)
    for r in range(6):
        total = -shift[r]
        for i in range(choice.shape[0]):
            if choice[i] >= 0:
                total += points[r, choice[i]]
        out[r] = total
    return h


@compiled
def climb(state, target, task, body, stop, cap, score, choice, short):
    """Pivot until no vertex improves ``target``; return (solved, upper bound on q)."""
    basis, inverse, directions, kinds, _, picks = state
    points, starts, zero, shift = body[0], body[1], body[5], body[6]
    few, names, counts, few_score = short
    wide = few.shape[1] > 0
    listed = wide and counts.max() > 0
    u, vertex = np.empty(6), np.empty(6)
    weight, column = np.empty(6), np.empty(6)
    upper = np.inf
    for step in range(cap):
        if step % 40 == 0:
            if step > 0 and not invert(basis, inverse):
                return False, upper
            for r in range(6):
                weight[r] = 0.0
                u[r] = 0.0
            for r in range(6):
                for c in range(6):
                    weight[r] += inverse[r, c] * target[c]
                    u[c] += inverse[r, c]
        away = 0.0
        for r in range(6):
            away += u[r] * shift[r]
        h = 0.0
        if listed:
            h = _short_best(u, few, names, counts, zero, few_score, choice) - away
        # Less of a gain may be round-off of a long u about a vertex that is in the basis.
        if not listed or h <= 1.0 + GAIN:
            h = best_of(u, points, starts, zero, score, choice) - away
            reach = 0.0
            for r in range(6):
                reach += u[r] * task[r]
            if reach > 0.0 and h < upper * reach:
                upper = h / reach
            if h <= 1.0 + stop:
                return True, upper
            if wide:
                listed = _remember(points, choice, short) or listed
        for r in range(6):
            total = -shift[r]
            for i in range(choice.shape[0]):
                if choice[i] >= 0:
                    total += points[r, choice[i]]
            vertex[r] = total
        for r in range(6):
            total = 0.0
            for c in range(6):
                total += inverse[r, c] * vertex[c]
            column[r] = total
        leave, ratio = -1, np.inf
        for r in range(6):
            if column[r] > 1e-11:
                value = max(weight[r], 0.0) / column[r]
                if leave < 0 or value < ratio * (1.0 - 1e-13) or (
                    value <= ratio * (1.0 + 1e-13) and column[r] > column[leave]
                ):
                    leave, ratio = r, value
        if leave < 0:
            return False, upper
        kinds[leave] = 0
        for r in range(6):
            basis[r, leave] = vertex[r]
            directions[leave, r] = u[r]
        for i in range(choice.shape[0]):
            picks[leave, i] = choice[i]
        total = 0.0
        for r in range(6):
            total += column[r]
        scale = 1.0 / column[leave]
        share = weight[leave] * scale
        for c in range(6):
            inverse[leave, c] *= scale
            u[c] += (1.0 - total) * inverse[leave, c]
        for r in range(6):
            if r != leave:
                factor = column[r]
                weight[r] -= factor * share
                for c in range(6):
                    inverse[r, c] -= factor * inverse[leave, c]
        weight[leave] = share
    return False, upper
