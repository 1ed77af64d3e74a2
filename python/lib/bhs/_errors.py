"""What is wrong with a scene, or with what was asked of it."""

from __future__ import annotations

import json
from dataclasses import dataclass


@dataclass(frozen=True)
class Diagnostic:
    """One finding about a scene. Lines and columns count from 1, columns in characters; `None` where it is about no place in a text."""

    severity: str
    """`error` or `warning`."""
    code: str
    """Stable name of the kind of finding, such as `unknown-parameter`."""
    message: str
    """The finding in one sentence."""
    file: str | None = None
    """The file; `<text>` is that of `bhs.loads`, `<command line>` what `Scene.render` changes of it."""
    line: int | None = None
    column: int | None = None
    end_line: int | None = None
    end_column: int | None = None
    """The column behind the last one."""
    label: str | None = None
    """What is said under the place."""
    hint: str | None = None
    """What to do."""

    @classmethod
    def _of_json(cls, text: str) -> Diagnostic:
        found = json.loads(text)
        end = found.get("end") or {}
        return cls(
            severity=found["severity"],
            code=found["code"],
            message=found["message"],
            file=found.get("file"),
            line=found.get("line"),
            column=found.get("column"),
            end_line=end.get("line"),
            end_column=end.get("column"),
            label=found.get("label") or None,
            hint=found.get("help"),
        )


class Error(Exception):
    """What bhs raises. `str()` is the message as the program draws it, with the places in the text."""

    diagnostics: list[Diagnostic]
    """What was found wrong with a scene, in the order of its text, warnings too; empty if it is not about a scene."""

    def __init__(self, message: str, diagnostics: list[Diagnostic] | None = None) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics or []

    def __reduce__(self) -> tuple[type[Error], tuple[str, list[Diagnostic]]]:
        return type(self), (str(self), self.diagnostics)

    @classmethod
    def _of(cls, message: str, diagnostics: list[str]) -> Error:
        return cls(message, [Diagnostic._of_json(text) for text in diagnostics])


class SceneWarning(UserWarning):
    """What the user should know of a scene or of a picture; it was loaded, or rendered, all the same."""
