"""How parts of an entry are compiled that only compiled code calls."""

from __future__ import annotations

from functools import partial

from graspq._compiled.jit import compiled

# Without the wrappers by which Python and C would call it, a part compiles in two thirds of the
# time. Calling one from Python fails.
part = partial(compiled, no_cpython_wrapper=True, no_cfunc_wrapper=True)
