# SPDX-License-Identifier: Apache-2.0
"""A scene as nested dictionaries, {"light": {"up_mm": 20}, "mode": "surface"}, and as what the program and the server
take."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Union

from . import fanlight_pb2 as pb
from .errors import ValueNotAllowed

Value = Union[float, int, str]
Scene = Mapping[str, Any]
"""Groups of fields; the fields `mode` and `refresh` stand beside them. A dotted name, "light.up_mm", is one too."""


def flat(scene: Scene) -> dict[str, Value]:
    """Values by dotted name. TypeError for what is neither a number nor a text."""
    values: dict[str, Value] = {}
    for name, value in scene.items():
        if isinstance(value, Mapping):
            values.update(flat({f"{name}.{field}": each for field, each in value.items()}))
        elif isinstance(value, bool) or not (isinstance(value, (int, float, str)) or hasattr(value, "__float__")):
            raise TypeError(f"{name} is {value!r}, expected a number, a text, or a group of fields")
        else:
            values[name] = value if isinstance(value, (int, float, str)) else float(value)
    return values


def options(scene: Scene) -> Iterator[str]:
    """As options of the program: --light.up_mm=20, ..."""
    for name, value in flat(scene).items():
        yield f"--{name}={value!r}" if isinstance(value, float) else f"--{name}={value}"


def message(scene: Scene, fields: Iterable[pb.SceneField]) -> pb.Scene:
    """As a message of the fields that it has. ValueNotAllowed for a name or a choice that the server does not know."""
    known = {field.name: field for field in fields}
    result = pb.Scene()
    for name, value in flat(scene).items():
        field = known.get(name)
        if field is None:
            raise ValueNotAllowed(_unknown(name, known), name)
        target: Any = result
        *groups, last = name.split(".")
        for group in groups:
            target = getattr(target, group)
        setattr(target, last, _number_or_text(field, value))
    return result


def values(scene: pb.Scene, fields: Iterable[pb.SceneField]) -> dict[str, Any]:
    """The opposite: nested dictionaries, with the names of choices."""
    result: dict[str, Any] = {}
    for field in fields:
        source: Any = scene
        target = result
        *groups, last = field.name.split(".")
        for group in groups:
            source = getattr(source, group)
            target = target.setdefault(group, {})
        value = getattr(source, last)
        target[last] = field.choices[value] if field.choices and value < len(field.choices) else value
    return result


def _number_or_text(field: pb.SceneField, value: Value) -> Value:
    if field.is_text:
        if isinstance(value, str):
            return value
        raise ValueNotAllowed(f"{field.name} is {value}, expected a text", field.name)
    if field.choices:
        if value in field.choices:
            return list(field.choices).index(str(value))
        choices = ", ".join(field.choices)
        raise ValueNotAllowed(f"{field.name} is {value!r}, expected {choices}", field.name, choices=field.choices)
    if isinstance(value, str):
        raise ValueNotAllowed(f"{field.name} is {value!r}, expected a number", field.name)
    # A field of whole numbers takes no float, not even 3.0.
    return int(value) if field.step >= 1 and float(value).is_integer() else value


def _unknown(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1)
    near = near or [each for each in known if each.split(".")[-1] == name][:1]
    meant = f", expected for example {near[0]}" if near else ""
    return f"the scene has no field {name}{meant}"
