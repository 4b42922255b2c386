"""Ctrl-C and SIGTERM: a run stops in order, and never in the middle of a write."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from multiprocessing import resource_tracker
from types import FrameType, TracebackType


class Stopped(KeyboardInterrupt):
    """SIGTERM, raised where Ctrl-C would be."""


class StopSignals:
    """While it is entered, SIGTERM stops the run as Ctrl-C does; only the first one counts.

    Outside the main thread, which alone may touch signals, it does nothing.
    """

    def __init__(self) -> None:
        self._before: dict[signal.Signals, object] = {}
        self._held = self._ignored = False
        self._pending: type[KeyboardInterrupt] | None = None

    def __enter__(self) -> StopSignals:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                if signal.getsignal(number) != signal.SIG_IGN:  # a background job stays one
                    self._before[number] = signal.signal(number, self._stop)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # pyright: ignore[reportArgumentType]

    def _stop(self, number: int, frame: FrameType | None) -> None:
        if self._ignored:
            return
        error = Stopped if number == signal.SIGTERM else KeyboardInterrupt
        if self._held:
            self._pending = error
        else:
            raise error

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """A stop that comes inside the block is raised at its end."""
        self._held = True
        try:
            yield
        finally:
            self._held = False
        if self._pending is not None and not self._ignored:
            raise self._pending

    def ignore_further(self) -> None:
        """From now on both signals do nothing."""
        self._ignored = True


@contextlib.contextmanager
def interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the block ends; processes started in it never see it.

    A terminal sends Ctrl-C to every process of the group: a worker that it hits while starting
    would print a traceback. Blocked signals stay blocked in children and in threads.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it unblocks SIGINT when it starts, so start it before
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
