# SPDX-License-Identifier: Apache-2.0
"""The errors of the package. Each has the sentence of the server or the program as its text."""

from __future__ import annotations

from collections.abc import Sequence


class FanlightError(Exception):
    """Any failure of Fanlight. Errors of Python itself, such as TypeError, are mistakes of the call."""


class ProgramMissing(FanlightError):
    """The program `fanlight` was not found, or lacks a part that is needed."""


class RenderFailed(FanlightError):
    """The program refused the recording or could not render it. `exit_code`: 1, or 2 for a wrong option."""

    def __init__(self, sentence: str, exit_code: int) -> None:
        super().__init__(sentence)
        self.exit_code = exit_code


class ConnectionFailed(FanlightError):
    """The server could not be reached, or speaks another protocol."""


class ConnectionLost(FanlightError):
    """The connection to the server broke, or the server ended it."""


class NotAuthenticated(FanlightError):
    """The server asks for a token, or refused the one that it got."""


class Refused(FanlightError):
    """The server did not carry out a request."""


class NotPermitted(Refused):
    """The role of the token does not allow the request."""


class ControlHeld(Refused):
    """Another client is in control. `holder`: its name."""

    def __init__(self, sentence: str, holder: str) -> None:
        super().__init__(sentence)
        self.holder = holder


class ValueNotAllowed(Refused, ValueError):
    """A field or a value that the scene does not have.

    `field` is its dotted name. Of a number out of range, `minimum` and `maximum` are set; of a name that is no
    choice, `choices`.
    """

    def __init__(
        self,
        sentence: str,
        field: str,
        minimum: float | None = None,
        maximum: float | None = None,
        choices: Sequence[str] = (),
    ) -> None:
        super().__init__(sentence)
        self.field = field
        self.minimum = minimum
        self.maximum = maximum
        self.choices = tuple(choices)


class TimedOut(FanlightError, TimeoutError):
    """The server did not answer, or sent no picture, in time."""
