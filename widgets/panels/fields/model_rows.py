"""Rows of a form made from the fields of a model: types, units by the suffix of a name, titles and descriptions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from annotated_types import MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QLabel, QWidget

from riglens.core.plain import Frozen
from riglens.widgets.panels.controls.building import plain_label
from riglens.widgets.panels.controls.scrolled import breakable
from riglens.widgets.panels.fields.edits import (
    IntegerEdit,
    ListEdit,
    NumberEdit,
    TextEdit,
    ValueEdit,
    WordsEdit,
)
from riglens.widgets.panels.fields.form import ChoiceBox, Form, Path, read, write
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, NO_UNIT, PIXELS, Unit
from riglens.widgets.sensors.field_variants import FieldVariant, FieldVariants

_UNITS = {"deg": DEGREES, "m": METRES, "px": PIXELS}
_SHORT = 2
"""Names of so few letters are symbols: they keep their case."""
_PER_ROW, _ALL_PER_ROW = 2, 3
"""Coefficients side by side; parts that are so few are all."""
_FINE_STEP = 0.001
"""Of numbers without a unit, such as coefficients."""
_NARROWEST = "-180"


def title_of(name: str, info: FieldInfo) -> str:
    """Return the label of a field: its title, or its name without the unit."""
    if info.title:
        return info.title
    words = name.strip("_").split("_")
    plain = " ".join(words[:-1] if words[-1] in _UNITS and len(words) > 1 else words)
    return plain if len(plain) <= _SHORT else plain[:1].upper() + plain[1:]


def titles_of(model: type[BaseModel]) -> dict[str, str]:
    """Return the titles of a model's fields by name, without those that read as words of a sentence."""
    fields = model.model_fields.items()
    return {name: title_of(name, info) for name, info in fields if info.title or "_" in name}


def _plain(annotation: Any) -> Any:
    return _plain(get_args(annotation)[0]) if get_origin(annotation) is Annotated else annotation


def _alternatives(annotation: Any) -> list[Any]:
    """Return the types that a value may have."""
    plain = _plain(annotation)
    if get_origin(plain) in (Union, UnionType):
        return [found for each in get_args(plain) for found in _alternatives(each)]
    return [plain]


class _Kind(NamedTuple):
    """The type that is edited, whether there may be no value, and its unit and step."""

    plain: Any
    is_optional: bool
    unit: Unit
    step: float


def _kind_of(name: str, info: FieldInfo) -> _Kind:
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    unit = _UNITS.get(str(extra.get("unit", name.rsplit("_", 1)[-1])), NO_UNIT)
    found = _alternatives(info.annotation)
    plain = next(kind for kind in found if kind is not NoneType and not _is_model(kind))
    return _Kind(plain, NoneType in found, unit, float(str(extra.get("step", 1.0))))


def is_editable(info: FieldInfo) -> bool:
    """Return whether a form has an input for a field: a value, one of several, or a list; not so for other types."""
    plain = [kind for kind in _alternatives(info.annotation) if kind is not NoneType and not _is_model(kind)]
    return bool(plain) and (
        plain[0] in (bool, int, float, str) or get_origin(plain[0]) in (Literal, tuple, list)
    )


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _edit(plain: Any, kind: _Kind) -> ValueEdit[Any]:
    if plain is int:
        return IntegerEdit(kind.is_optional, kind.unit)
    if plain is float:
        return NumberEdit(kind.step, kind.unit, is_optional=kind.is_optional)
    if plain is str:
        return TextEdit()
    if get_args(plain)[:1] == (str,):
        return WordsEdit()
    return ListEdit(kind.unit, kind.is_optional)


class ModelRows:
    """Builder of rows in a form; `words` are the titles of the fields that have one."""

    def __init__(self, form: Form, is_shared: bool = False) -> None:
        self._form, self._is_shared = form, is_shared
        self._variants: list[tuple[FieldVariant, list[QWidget]]] = []
        self._notes: list[tuple[QLabel, FieldVariant]] = []

    def add(
        self, model: type[BaseModel], name: str, path: Path = (), variant: FieldVariant | None = None
    ) -> QWidget:
        """Add the row of one field of a model, which lies at a path in the subject of the form."""
        return self.add_field(name, model.model_fields[name], path, variant)

    def add_field(
        self, name: str, info: FieldInfo, path: Path = (), variant: FieldVariant | None = None
    ) -> QWidget:
        """Add the row of a field; its `titles` name the values to choose among."""
        title, tip, whole = title_of(name, info), info.description or "", (*path, name)
        if path and isinstance(path[-1], int):
            title = f"{path[-1] + 1}  {title}"
        kind = _kind_of(name, info)
        if kind.plain is bool:
            check = QCheckBox()
            self._form.bind_check(check, read(whole), write(whole), name)
            return self._row(title, [check], tip)
        if get_origin(kind.plain) is Literal:
            box = ChoiceBox()
            extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
            titles = extra.get("titles")
            for value in get_args(kind.plain):
                box.addItem(str(titles[value] if isinstance(titles, dict) else value), value)
            self._form.bind_choice(box, read(whole), write(whole), name)
            return self._row(title, [box], tip)
        if get_origin(kind.plain) is tuple and Ellipsis not in get_args(kind.plain):
            return self._add_items(title, tip, whole, kind, variant)
        if get_origin(kind.plain) is tuple and _is_model(get_args(kind.plain)[0]):
            return self._add_models(title, whole, info, get_args(kind.plain)[0])
        edit = _edit(kind.plain, kind)
        self._bind(edit, whole, f"{name}.list" if isinstance(edit, ListEdit) else name, title, variant)
        return self._row(title, [edit], tip)

    def add_variants(self, model: type[BaseModel], variants: FieldVariants) -> None:
        """Add a choice between variants, and the rows of each, of which one set is shown."""
        box = ChoiceBox()
        for variant in variants.variants:
            box.addItem(variant.title, variant)
        self._row(variants.title, [box], variants.tip)
        self._form.bind_choice(
            box,
            lambda subject: next(variant for variant in variants.variants if variant.is_used(subject)),
            lambda subject, variant: subject if variant.is_used(subject) else variant.given(subject),
            f"{variants.name}.way",
        )
        for variant in variants.variants:
            rows = [self.add(model, field, variant=variant) for field in variant.fields]
            if variant.model is not None:
                rows += self._add_parts(variants, variant, variant.model)
            if variant.note is not None:
                label = plain_label(style=f"{variants.name}.note", wraps=True)
                label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
                self._notes.append((label, variant))
                rows.append(self._row("", [label], ""))
            self._variants.append((variant, rows))

    def show_ways(self, subject: Any) -> None:
        """Show the rows of the variants that a subject uses."""
        for variant, rows in self._variants:
            for row in rows:
                self._form.show_row(row, variant.is_used(subject))
        for label, variant in self._notes:
            if variant.note is not None and variant.is_used(subject):
                label.setText(breakable(variant.note(subject)))

    def _add_parts(
        self, variants: FieldVariants, variant: FieldVariant, model: type[BaseModel]
    ) -> list[QWidget]:
        """Add the numbers of a model side by side: all of a range, or coefficients two by two."""
        unit = _UNITS.get(variants.name.rsplit("_", 1)[-1], NO_UNIT)
        step = _FINE_STEP if unit is NO_UNIT else 1.0
        numbers = {part: _plain(info.annotation) for part, info in model.model_fields.items()}
        parts = [part for part, plain in numbers.items() if plain in (int, float)]
        titles = {part: title_of(part, model.model_fields[part]) for part in parts}
        per_row = len(parts) if len(parts) <= _ALL_PER_ROW else _PER_ROW
        models = [other for other in variants.variants if other.model is not None]
        owner = variants.name if len(models) == 1 else f"{variants.name}.{model.__name__}"
        rows = []
        for start in range(0, len(parts), per_row):
            line: list[QWidget] = []
            for part in parts[start : start + per_row]:
                word, is_float = part.strip("_"), numbers[part] is float
                edit = _edit(numbers[part], _Kind(numbers[part], False, unit if is_float else NO_UNIT, step))
                edit.keep_room_for(_NARROWEST)
                self._bind(
                    edit, (variants.name, part), f"{owner}.{word}", f"{variants.title} {word}", variant
                )
                line += [QLabel(titles[part]), edit] if line else [edit]
            rows.append(
                self._row(titles[parts[start]] if per_row == _PER_ROW else "", line, model_tip(model))
            )
        for part, plain in numbers.items():
            if get_origin(plain) is tuple and _is_model(get_args(plain)[0]):
                rows.append(self.add(model, part, (variants.name,)))
        return rows

    def _add_models(self, title: str, path: Path, info: FieldInfo, model: type[Frozen]) -> QWidget:
        """Add how many parts of a model a field holds, and the rows of each, of which those of the first are shown."""
        box = ChoiceBox()
        row = self._row(title, [box], info.description or "")
        least = next((rule.min_length for rule in info.metadata if isinstance(rule, MinLen)), 0)
        most = next(rule.max_length for rule in info.metadata if isinstance(rule, MaxLen))
        for count in range(least, most + 1):
            box.addItem(str(count) if count else "none", count)
        for count in range(1, most + 1):
            rows: list[QWidget] = []
            variant = FieldVariant(f"{count}", _holds(path, count), lambda subject: subject, model=model)
            for field in model.model_fields:
                rows.append(self.add(model, field, (*path, count - 1), variant))
            self._variants.append((variant, rows))
        found, put = read(path), write(path)
        self._form.bind_choice(
            box,
            lambda subject: None if found(subject) is None else len(found(subject)),
            lambda subject, count: put(subject, _of_length(found(subject), count, model)),
            f"{path[-1]}.count",
        )
        return row

    def _add_items(
        self, title: str, tip: str, path: Path, kind: _Kind, variant: FieldVariant | None = None
    ) -> QWidget:
        """Add the items of a tuple side by side; the description names them up to its semicolon."""
        items = [_plain(item) for item in get_args(kind.plain)]
        named = [part.split()[0].strip(".").lower() for part in tip.split(";")[0].split(",") if part.strip()]
        names = named if len(named) == len(items) else [str(place) for place in range(len(items))]
        between = "×" if items[0] is int else names[1] if len(items) == _PER_ROW else ""
        line: list[QWidget] = []
        for place, (item, name) in enumerate(zip(items, names, strict=True)):
            edit = _edit(item, kind)
            self._bind(edit, (*path, place), f"{path[-1]}.{name}", f"{title} {name}", variant)
            line += [QLabel(between), edit] if line and between else [edit]
        return self._row(title, line, tip)

    def _bind(
        self, edit: ValueEdit[Any], path: Path, name: str, title: str, variant: FieldVariant | None = None
    ) -> None:
        """Bind an edit to what lies at a path, where that variant is in use."""
        edit.setAccessibleName(title)
        getter, setter = read(path), write(path)

        def shown(subject: Any) -> Any:
            return getter(subject) if variant is None or variant.is_used(subject) else None

        def changed(subject: Any, value: Any) -> Any:
            is_part = variant is not None and (variant.model is not None or isinstance(path[-1], int))
            if variant is not None and is_part and not variant.is_used(subject):
                raise ValueError(f"is specified differently: choose '{variant.title}' for all first")
            return setter(subject, value)

        self._form.bind_edit(edit, shown, changed, name, path)

    def _row(self, title: str, widgets: Sequence[QWidget], tip: str) -> QWidget:
        if self._is_shared:
            self._form.share(*(widget for widget in widgets if not isinstance(widget, QLabel)))
        return self._form.add_row(title, widgets, tip)


def _holds(path: Path, count: int) -> Callable[[Any], bool]:
    """Return whether a field of a subject holds that many parts."""
    found = read(path)
    return lambda subject: len(found(subject) or ()) >= count


def _of_length(parts: tuple[Any, ...], count: int, model: type[Frozen]) -> tuple[Any, ...]:
    """Return the first parts; where there are too few, the last one again, or one as it is by default."""
    return (*parts[:count], *((parts[-1:] or (model(),)) * (count - len(parts))))


def model_tip(model: type[BaseModel]) -> str:
    """Return the summary of a model."""
    return (model.__doc__ or "").strip().split("\n")[0].replace("`", "")
