"""What is known of a setting, written once: beside its field, in a frozen dataclass.

    @dataclass(frozen=True)
    class TrialSettings:
        timestep: float = field(
            default=0.002, metadata=setting("Simulation step.", span=(1e-4, 5e-3), unit="s")
        )

From these lines come the checks (``check``), the command-line options (``cli/options.py``) and the
page of settings in the documentation (``cli/settings_page.py``).
"""

from __future__ import annotations

import dataclasses
import functools
import math
import types
import typing
from dataclasses import dataclass
from typing import Any

from sdh_sim.errors import SettingsError


@dataclass(frozen=True)
class Setting:
    """A line of a table of settings.

    Attributes:
        name: of the field; with dashes, of the option.
        type: of a value, without the None that stands for a value left out.
        default: value of a setting left out; None where there is none.
        required: it cannot be left out.
        meaning: sentences for users.
        choices: the values that are allowed, where they are few.
        span: smallest and largest number that is allowed.
        unit: of the numbers, SI.
        allowed: in words, what neither choices nor a span say.
        shown: the default in words, where the value does not tell.
        option: whether the command line has it.
        placeholder: what stands for the value in the help; empty for its type.
    """

    name: str
    type: Any
    default: Any
    required: bool
    meaning: str
    choices: tuple[str, ...] = ()
    span: tuple[float, float] | None = None
    unit: str = ""
    allowed: str = ""
    shown: str = ""
    option: bool = True
    placeholder: str = ""

    @property
    def flag(self) -> str:
        """The option's name."""
        return "--" + self.name.replace("_", "-")

    @property
    def help(self) -> str:
        """What it means, with its unit before the last full stop."""
        return f"{self.meaning[:-1]} [{self.unit}]." if self.unit else self.meaning

    @property
    def default_text(self) -> str:
        """The default as users read it, empty where there is none."""
        if self.shown:
            return self.shown
        if self.default is None or self.default == () or self.type is bool:
            return ""
        values = self.default if isinstance(self.default, tuple) else (self.default,)
        return " ".join(_text(value) for value in values)

    @property
    def allowed_text(self) -> str:
        """The allowed values as users read them, empty where any will do."""
        if self.choices:
            return ", ".join(self.choices)
        if self.span is None:
            return self.allowed
        low, high = map(_text, self.span)
        return f"at least {low}" if math.isinf(self.span[1]) else f"{low} to {high}"


def setting(
    meaning: str,
    *,
    choices: tuple[str, ...] = (),
    span: tuple[float, float] | None = None,
    unit: str = "",
    allowed: str = "",
    shown: str = "",
    option: bool = True,
    placeholder: str = "",
) -> dict[str, Any]:
    """Metadata of a dataclass's field; the arguments are the attributes of ``Setting``."""
    return {
        "setting": {
            "meaning": meaning,
            "choices": choices,
            "span": span,
            "unit": unit,
            "allowed": allowed,
            "shown": shown,
            "option": option,
            "placeholder": placeholder,
        }
    }


@functools.cache
def settings_of(table: type) -> dict[str, Setting]:
    """The settings of a dataclass by name, in the order of its fields."""
    hints = typing.get_type_hints(table)
    found = {}
    for field in dataclasses.fields(table):
        if "setting" in field.metadata:
            required = field.default is dataclasses.MISSING
            found[field.name] = Setting(
                field.name,
                _without_none(hints[field.name]),
                None if required else field.default,
                required,
                **field.metadata["setting"],
            )
    return found


def check(settings: Any) -> None:
    """Raise SettingsError where a value is none of its choices or out of its span."""
    for line in settings_of(type(settings)).values():
        value = getattr(settings, line.name)
        if value is None and line.default is None:  # left out
            continue
        if line.choices and value not in line.choices:
            raise SettingsError(
                f"{line.name}: got {value!r}; choose one of {', '.join(line.choices)}"
            )
        if line.type is bool and not isinstance(value, bool):
            raise SettingsError(f"{line.name}: got {value!r:.80}; give true or false")
        if line.span is not None:
            _check_span(line, value, *line.span)


def _check_span(line: Setting, value: object, low: float, high: float) -> None:
    number = isinstance(value, (int, float)) and low <= value <= high
    whole = isinstance(value, int) and not isinstance(value, bool)
    if line.type is int and math.isinf(high) and not (number and whole):
        raise SettingsError(f"{line.name}: got {value!r}; give a whole number of at least {low:g}")
    if not number:
        allowed = f"{low:g} to {high:g} {line.unit}".rstrip()
        raise SettingsError(f"{line.name}: got {value!r}; allowed is {allowed}")
    if line.type is int and not whole:
        raise SettingsError(f"{line.name}: got {value!r}; give a whole number, {low:g} to {high:g}")


def _without_none(kind: Any) -> Any:
    if isinstance(kind, types.UnionType):
        (kind,) = (part for part in kind.__args__ if part is not types.NoneType)
    return kind


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}".replace("e+0", "e").replace("e-0", "e-")
    return str(value)
