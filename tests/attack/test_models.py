"""Bad models beside good ones, through every command that shows frames: each loses its own part alone, or works.

What is done about a model is done at one place, `engine.model_runner`: sixty of them (`SIXTY`) show that through run,
watch and (`test_envs`) envs. That tune, leaderboard and reproduce show frames by that place too, the `WORST` show, one
of each kind. With COLIAS_ATTACK_FULL=1 all models go through the first, and the sixty through the last.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.attack import commands, models
from tests.attack.commands import Command, Reference, show
from tests.attack.judging import expect_none, problems, refusal, strict_json
from tests.attack.model_files import Case
from tests.attack.processes import colias
from tests.attack.scale import FULL, some

pytestmark = pytest.mark.attack

LATER = ("raises-at-last", "answers-hs-nan-at-last")
"""They need to know the last frame, which not every command has in every trial."""
SLOW = ("changes-frames-from-a-thread",)
SIXTY = tuple(
    case
    for case in (*models.RAISING, *models.WRONG, *models.MUTATING, *models.MEDDLING)
    if case not in models.MEDDLING
    or case.name in ("prints", "raises-on-float-errors", "turns-opencv-off", "changes-folder")
    if case.name not in (*LATER, *SLOW)
)
"""Through every command."""
TOGETHER = models.batches(models.TOGETHER if FULL else SIXTY, 9)
"""At most as many as a run names one by one when they fail."""

SHOWING = (commands.RUN, commands.OFFLINE, commands.WATCH, commands.PLAY)
PARAMETERS = [case for case in models.DECLARED_WRONG if case.name.startswith("parameters")]
STATE = tuple(case for case in models.MEDDLING if case.name not in ("keeps-300-mb", "starts-a-program"))
WORST = tuple(
    case
    for case in models.EVERY
    if case.name
    in (
        "raises-at-5", "raises-system-exit", "raises-keyboard-interrupt", "raises-markup", "answers-none",
        "answers-hs-string", "answers-spikes-1.5", "sets-frame", "raises-on-float-errors",
    )
)  # fmt: skip


def attributed(command: Command, cases: Sequence[Case], folder: Path, honest: Reference) -> list[str]:
    """The problems of all cases in one command; where there are, and COLIAS_ATTACK_ALONE is set, of each case alone."""
    faults = problems(command, cases, folder, honest)
    if not faults or len(cases) == 1 or "COLIAS_ATTACK_ALONE" not in os.environ:
        return faults
    alone = []
    for case in cases:
        place = folder.parent / case.name
        place.mkdir()
        alone += [f"alone: {case.name}: {fault}" for fault in problems(command, [case], place, honest)]
    return [*faults, *(alone or ["alone none of them does that"])]


def _id(cases: object) -> str:
    return f"{cases[0].name}-and-{len(cases) - 1}" if isinstance(cases, tuple) else ""


def test_there_are_enough_of_them():
    assert len({case.text for case in models.EVERY}) >= len({case.text for case in SIXTY}) >= 60


@pytest.mark.parametrize(
    ("command", "cases"),
    [
        *((command, cases) for command in (commands.RUN, commands.WATCH) for cases in TOGETHER),
        *((command, cases) for command in (commands.OFFLINE, commands.PLAY) for cases in some(TOGETHER, 1)),
    ],
    ids=lambda given: given.name if isinstance(given, Command) else _id(given),
)
def test_each_loses_its_own_part_alone(command, cases, folder, honest):
    expect_none(attributed(command, cases, folder, honest(command)))


@pytest.mark.parametrize("cases", some(models.batches(STATE, 6), 1), ids=_id)
def test_what_they_change_of_the_process_is_not_felt_without_workers(cases, folder, honest):
    expect_none(attributed(commands.INSIDE, cases, folder, honest(commands.INSIDE)))


@pytest.mark.parametrize("case", models.ALONE, ids=lambda case: case.name)
@pytest.mark.parametrize("command", some([commands.WATCH, commands.OFFLINE], 1), ids=lambda c: c.name)
def test_what_touches_streams_and_processes(command, case, folder, honest):
    if (command is commands.WATCH and "std" in case.name) or "fd" in case.name:
        return _leaves_nothing_damaged(command, case, folder, honest(command))
    expect_none(problems(command, [case], folder, honest(command)))


def _leaves_nothing_damaged(command: Command, case: Case, folder: Path, honest: Reference) -> None:
    """Without its streams a command cannot say much; its files and its status can."""
    commands.furnish(folder)
    ended = show(command, folder, [case.write(folder)], honest.last)
    assert ended.crashes() == [] and ended.left == ()
    if ended.status == 0:
        tables = command.tables(folder)
        assert {label: tables[label] for label in command.others} == {
            label: honest.tables[label] for label in command.others
        }
        assert tables[case.label] == honest.tables["twin"]
    assert_readable(folder)


def assert_readable(folder: Path) -> None:
    """Every file that has its final name is whole."""
    for path in folder.rglob("*"):
        if path.suffix == ".parquet":
            pq.read_table(path)
        elif path.suffix == ".json":
            strict_json(path)
        elif path.suffix == ".rrd":
            read_recording(path)


def read_recording(path: Path) -> None:
    """Read every chunk of a recording."""
    import rerun as rr

    assert list(rr.chunk.RrdReader(path).stream().to_chunks())


# Killers of the process.


@pytest.mark.parametrize("case", some(models.KILLERS, 1), ids=lambda case: case.name)
def test_a_killer_loses_the_trial_and_the_run_goes_on(case, folder, honest):
    command, usual = commands.OFFLINE, honest(commands.OFFLINE)
    commands.furnish(folder)
    ended = show(command, folder, [case.write(folder)], usual.last)
    assert (ended.status, ended.crashes(), ended.left) == (1, [], ()), ended
    (line,) = [line for line in ended.err.splitlines() if "trial 1 failed" in line]
    assert "after 3 attempts" in line and "dark" in line
    tables = command.tables(folder)
    light = {name: [row for row in rows if row["trial"] == 0] for name, rows in usual.tables.items()}
    assert {name: tables[name] for name in ("emd", "dsnn", case.label)} == {
        "emd": light["emd"], "dsnn": light["dsnn"], case.label: light["twin"]
    }  # fmt: skip
    (failure,) = strict_json(folder / "out" / "failures.json")
    assert (failure["trial"], failure["model"], failure["attempts"]) == (1, "", 3)
    resumed = colias(folder, [*command.words[:-2], "--out", "out", *_models(case, command)])
    assert resumed.status == 1 and resumed.crashes() == [], resumed
    assert command.tables(folder) == tables


def _models(case: Case, command: Command) -> list[str]:
    return ["--model", f"{case.name}.py", "--model", "dsnn"]


@pytest.mark.parametrize("case", models.KILLERS, ids=lambda case: case.name)
@pytest.mark.parametrize("command", some([commands.WATCH, commands.PLAY], 1), ids=lambda c: c.name)
def test_a_killer_may_end_a_command_but_damages_no_file(command, case, folder):
    commands.furnish(folder)
    commands.film(folder / "film.avi", 30, dark=True)
    dark = ("--set", "plain.background_grey=30", "--set", "plain.grey=90") if command is commands.PLAY else ()
    ended = show(dataclasses.replace(command, words=(*command.words, *dark)), folder, [case.write(folder)])
    assert ended.crashes() == [] and ended.left == (), ended
    assert ended.status != 0 or case.name == "exits-with-0", "it did not kill anything"
    assert_readable(folder)


# Declarations that are wrong, names that are odd.


@pytest.mark.parametrize("case", some(models.DECLARED_WRONG, 10), ids=lambda case: case.name)
@pytest.mark.parametrize("command", [commands.WATCH], ids=lambda c: c.name)
def test_a_wrong_declaration_is_refused(command, case, folder, honest):
    commands.furnish(folder)
    before = {path.name for path in folder.iterdir()}
    ended = show(command, folder, [case.write(folder)], honest(command).last)
    if models.REFUSED in case.may and (ended.status == 2 or case.may == {models.REFUSED}):
        expect_none(refusal(ended))
        new_files = {path.name for path in folder.iterdir()} - before
        assert new_files <= {f"{case.name}.py", "__pycache__", "tmp"}, "it began"
    else:
        again = folder.parent / "again"
        again.mkdir()
        expect_none(problems(command, [case], again, honest(command)))


@pytest.mark.parametrize("case", some(models.NAMED, 2), ids=lambda case: case.name)
@pytest.mark.parametrize("command", [commands.RUN], ids=lambda c: c.name)
def test_an_odd_name_is_shown_as_it_is_or_refused(command, case, folder, honest):
    commands.furnish(folder)
    ended = show(command, folder, [case.write(folder)], honest(command).last)
    if ended.status == 2:
        expect_none(refusal(ended))
        return
    assert ended.crashes() == [] and case.label in ended.out, ended
    again = folder.parent / "again"
    again.mkdir()
    expect_none(problems(command, [case], again, honest(command)))


@pytest.mark.parametrize("case", some(PARAMETERS, 3), ids=lambda case: case.name)
def test_parameters_of_any_type_are_listed_or_refused(case, folder):
    ended = colias(folder, ["parameters", "--model", case.write(folder)])
    assert ended.crashes() == []
    assert ended.status == 0 or refusal(ended) == []
    ended = colias(folder, ["run", "clean", "--model", f"{case.name}.py", "--set", f"{case.label}.t_sp=odd"])
    expect_none(refusal(ended))


@pytest.mark.parametrize("case", some(models.MAPPED, 1), ids=lambda case: case.name)
def test_maps_that_are_none_cost_nobody_else_anything(case, folder, honest):
    usual = honest(commands.RUN)
    words = tuple(word for word in commands.RUN.words if word != "--no-recordings")
    expect_none(problems(dataclasses.replace(commands.RUN, words=words), [case], folder, usual))
    read_recording(folder / "out" / "recordings" / "trial-0000.rrd")


RECORDING = [("run", "tiny.py"), ("run", "clips.py"), ("play", "plain")]


@pytest.mark.parametrize("words", some(RECORDING, 1), ids=lambda w: w[1])
def test_recorded_frames_are_what_the_camera_saw(words, folder):
    """Whatever models do to the frames that they are shown, then or later."""
    kept = []
    for name, cases in (("honest", ()), ("spoilt", models.MUTATING)):
        place = folder / name
        place.mkdir()
        commands.furnish(place)
        if words[0] == "play":
            extra = ["--set", "plain.rows=48", "--set", "plain.columns=64", "--no-view", "--record", "seen.rrd"]
        else:
            extra = ["--workers", "1", "--out", "out"]
        given = [word for case in cases for word in ("--model", case.write(place))]
        ended = colias(place, [*words, *extra, *given, "--model", "dsnn"])
        assert ended.status in (0, 1) and ended.crashes() == [], ended
        kept.append([pictures(path) for path in sorted(place.rglob("*.rrd"))])
    assert kept[0] == kept[1] and all(kept[0])


def pictures(path: Path) -> list[bytes]:
    """The encoded pictures in a recording, sorted: what was shown, not in which order it was written."""
    import rerun as rr

    blobs = []
    for chunk in rr.chunk.RrdReader(path).stream().to_chunks():
        if "maps" in chunk.entity_path or "layers" in chunk.entity_path:
            continue
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if "blob" in name or "buffer" in name:
                blobs += [bytes(blob) for row in batch[name].to_pylist() if row for blob in row]
    return sorted(blobs)


# The long commands, with the worst.


@pytest.mark.parametrize("cases", some([WORST, SIXTY], 1), ids=_id)
@pytest.mark.parametrize("command", [commands.TUNE, commands.LEADERBOARD], ids=lambda c: c.name)
def test_many_through_the_long_commands(command, cases, folder, honest):
    expect_none(problems(command, cases, folder, honest(command)))


@pytest.mark.parametrize(
    ("command", "usual", "cases"),
    some(
        [
            (commands.SMALL_REPRODUCE, commands.SMALL_GENERAL, WORST),
            (commands.SMALL_REPRODUCE, commands.SMALL_GENERAL, SIXTY),
            (commands.REPRODUCE, commands.GENERAL, WORST),
        ],
        1,
    ),
    ids=lambda given: given.name if isinstance(given, Command) else _id(given),
)
def test_many_through_reproduce(command, usual, cases, folder, honest):
    faults = problems(command, cases, folder, honest(usual))
    page = folder / "out" / "report.html"
    if page.exists() and "<b>fat" in page.read_text():
        faults.append("the report does not escape what models say")
    expect_none(faults)
