"""`riglens study`: studies of the paper, and of the metric itself."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter as Place
from inspect import Signature, signature
from pathlib import Path
from typing import Annotated, Any, get_type_hints

from cyclopts import Parameter

from riglens.app.commands.options import BUILD, SCENE, SCORE, JsonFigures, all_of, command, taken
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, show
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.studies.running import STUDIES, Job, Study


def study_command(name: str) -> Callable[..., None]:
    """Return the command of a study, from what the study is given by place and its options."""
    study = STUDIES[name]

    def run(
        *given: object,
        options: Any = study.options(),
        scene: SceneOptions = SceneOptions(),
        score: ScoreOptions = ScoreOptions(),
        out: Path = Path("out"),
        json: str | None = None,
    ) -> None:
        require_outputs([path for path in vars(options).values() if isinstance(path, Path)], json)
        found = STUDIES[name].run(options, Job(scene, score, out, TERMINAL), *given)
        if found.document is None:
            show(found.blocks, found.beside)
        else:
            deliver(found.document, json, lambda: show(found.blocks))

    places = list(_places(study))
    run.__name__ = name
    run.__annotations__ = {one.name: one.annotation for one in places}
    run.__signature__ = Signature(places)  # type: ignore[attr-defined]
    return command(run)


def _places(study: Study) -> list[Place]:
    """Return the parameters of the command of a study."""
    kinds = get_type_hints(study.run)
    _, _, *given = signature(study.run).parameters.values()
    places = [
        one.replace(
            kind=Place.VAR_POSITIONAL if one.kind is Place.VAR_POSITIONAL else Place.POSITIONAL_ONLY,
            annotation=Annotated[kinds[one.name], Parameter(name=study.given.metavar, help=study.given.help)],
        )
        for one in given
    ]
    options = {
        "options": (study.options(), all_of(study.options, None, {"workers": BUILD, "dask": BUILD})),
        "scene": (SceneOptions(), taken(SCENE, *study.scene)),
        "score": (ScoreOptions(), taken(SCORE, *study.score)),
    }
    for name, (usual, how) in options.items():
        if how.groups:
            places.append(_option(name, usual, Annotated[type(usual), how]))
    if study.has_json:
        places.append(_option("json", None, JsonFigures))
    if study.folder:
        folder = Annotated[Path, Parameter(metavar="DIR", help=f"Folder for {study.folder}.")]
        places.append(_option("out", Path("out"), folder))
    return places


def _option(name: str, usual: object, annotation: Any) -> Place:
    return Place(name, Place.KEYWORD_ONLY, default=usual, annotation=annotation)


table1 = study_command("table1")
accuracy = study_command("accuracy")
targets = study_command("targets")
detection = study_command("detection")
external = study_command("external")
stability = study_command("stability")
predicted = study_command("predicted")
