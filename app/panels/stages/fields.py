"""Fields of a scene, each with the widget that shows and sets it."""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from types import MappingProxyType
from typing import Any

import viser

from abi.scene.scene import Scene
from app.panels.widgets import DIGITS, Wake, label_of

Widgets = Mapping[str, viser.GuiInputHandle[Any]]
"""Widgets by the names of their fields, ``section.field``; of several numbers, all in a row."""
Labels = Mapping[str, str]
"""Labels of a dropdown, with the value that each stands for."""


class Fields:
    """Widgets that each show and set a field of the scene, or several numbers.

    ``{unit}`` in a widget's label stands for the scene's unit of length.
    """

    def __init__(
        self,
        widgets: Widgets,
        wake: Wake,
        options: Mapping[str, Labels] = MappingProxyType({}),
    ) -> None:
        """Have every widget wake the tab.

        Args:
            widgets: by field.
            wake: callback.
            options: labels of dropdowns, by field.
        """
        self._rows: list[tuple[list[str], Any, str]]
        self._rows = [(names.split(), widget, widget.label) for names, widget in widgets.items()]
        self._widgets = {name: widget for names, widget, _ in self._rows for name in names}
        self._options = options
        for _, widget, _ in self._rows:
            widget.on_update(wake)
            if isinstance(widget.value, float | tuple):
                widget.precision = DIGITS

    def __getitem__(self, field: str) -> Any:
        """The widget that shows a field."""
        return self._widgets[field]

    def read(self) -> dict[str, Any]:
        """Read the sections as typed; a label without a value as it is, for the scene to refuse."""
        sections: dict[str, Any] = {}
        for names, widget, _ in self._rows:
            values = widget.value if len(names) > 1 else (widget.value,)
            for name, value in zip(names, values, strict=True):
                section, field = name.split(".")
                if name in self._options:
                    value = self._options[name].get(value, value)
                sections.setdefault(section, {})[field] = value
        return sections

    def write(self, scene: Scene) -> None:
        """Show ``scene``."""
        for names, widget, label in self._rows:
            widget.label = label.replace("{unit}", scene.unit)
            value = attrgetter(*names)(scene)
            options = self._options.get(names[0])
            widget.value = value if options is None else label_of(options, value)
