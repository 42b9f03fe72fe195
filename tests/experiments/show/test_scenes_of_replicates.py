"""Which scene a replicate stands before: the photograph, a scene of the family, or a picture of a user's own."""

import dataclasses
import json

import cv2
import numpy as np

from dsnn.stimuli import SCENES
from experiments import Clip, Study
from experiments.base.files import to_json
from experiments.kinds import registry, sweep_plan
from experiments.kinds.clips import play_clip
from experiments.settings.models import choose
from experiments.settings.pictures import folder_pictures
from experiments.show.clips import clips_of, trials_of
from experiments.store.folder import differences
from tests.helpers.plans import planned

DEPTH = registry.find("clutter-depth")


def pictures_in(folder, *names, grey=120):
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        cv2.imwrite(str(folder / name), np.full((40, 60), grey + number, np.uint8))
    return folder


def backgrounds(clips):
    return {clip.build(0).params.background for clip in clips}


def test_replicate_0_has_the_photograph_and_the_others_go_through_the_scenes():
    assert clips_of(DEPTH.clips, 0) == list(DEPTH.clips)
    assert backgrounds(clips_of(DEPTH.clips, 0)) == {"photograph"}
    kinds = list(SCENES)
    for replicate in range(1, 10):
        assert backgrounds(clips_of(DEPTH.clips, replicate)) == {kinds[(replicate - 1) % 4]}


def test_a_clip_that_names_its_background_and_one_without_any_keep_theirs():
    named, plain = Clip("a", "cluttered", {"background": "pink"}), Clip("b", "plain")
    assert clips_of([named, plain], 3) == [named, plain]


def test_a_study_s_replicates_have_the_scenes_and_seeds_of_a_run_s():
    study_plan = sweep_plan.sweep_of(
        Study("s", "", claims=("C5",), experiments=("clutter-depth",), repeats=None, replicates=6), 3
    )
    ran = planned(DEPTH, repeats=6, seed=3)
    assert [(s.seed, s.condition) for s in study_plan.specs] == [(s.seed, s.condition) for s in ran.trials]
    assert [s.seed for s in ran.trials] == [3 + k for k in range(6) for _ in DEPTH.clips]


def test_a_run_s_description_has_the_scene_of_each_replicate():
    """So that a run before windows of one photograph is not gone on with before scenes."""
    assert planned(DEPTH, repeats=3).resolved["backgrounds"] == ["photograph", "dead-leaves", "pink"]
    assert "backgrounds" not in planned("clean").resolved
    study = Study("s", "", claims=("C5",), experiments=("clutter-depth",), repeats=None, replicates=2)
    assert sweep_plan.sweep_of(study).resolved["backgrounds"] == ["photograph", "dead-leaves"]


def test_rows_say_what_is_behind_the_object(tmp_path):
    small = [("rows", 32), ("columns", 64), ("width", 8.0), ("height", 8.0), ("duration_s", 0.2)]
    experiment = dataclasses.replace(DEPTH, clips=[Clip("a", "cluttered", [*small, ("motion", "looming")])])
    models = (choose("emd", "offline"),)
    user_pictures = folder_pictures(pictures_in(tmp_path / "own", "mine.png"))
    for pictures, expected in ((None, ["photograph", "dead-leaves"]), (user_pictures, ["mine.png", "mine.png"])):
        rows = [play_clip(s, frames=False).rows[0] for s in trials_of(experiment, models, 2, 0, pictures)]
        assert [row["background"] for row in rows] == expected


# --- a user's own pictures --------------------------------------------------------------------------------------------


def test_replicate_r_has_picture_r_in_the_order_of_names(tmp_path):
    user_pictures = folder_pictures(pictures_in(tmp_path / "own", "p10.png", "p2.png", "p1.png"))
    order = ["p1.png", "p2.png", "p10.png", "p1.png"]
    for replicate, name in enumerate(order):
        (path,) = backgrounds(clips_of(DEPTH.clips, replicate, user_pictures))
        assert path == str(tmp_path / "own" / name)


def test_the_wall_has_the_first_picture(tmp_path):
    folder = pictures_in(tmp_path / "own", "1.png", "2.png", "3.png")
    trial_plan = planned("general", ["dsnn"], repeats=2, seed=5, pictures=str(folder))
    assert {trial.settings.scene.wall for trial in trial_plan.trials} == {str(folder / "1.png")}
    assert "scene.wall" not in trial_plan.parameters  # as a replicate's wall is no setting of all trials


def test_a_run_is_not_gone_on_with_where_a_picture_has_changed(tmp_path):
    told = []
    for grey in (100, 101):
        folder = pictures_in(tmp_path / "own", "1.png", grey=grey)
        told.append(json.loads(to_json(planned(DEPTH, repeats=2, pictures=str(folder)).document())))
    (difference,) = differences(*told)
    assert difference[0].startswith("pictures")
    assert differences(told[0], told[0]) == []
