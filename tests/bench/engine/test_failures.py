"""Models, parameters and trials that break: what is lost is named, what is not goes on."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.helpers import user_files

QUICK = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "--no-recordings")

BROKEN_MODELS = {
    "MODEL = 3\n": "expected a dsnn.ModelEntry",
    "x = 1\n": "declares no MODEL",
    "import absent_module\n": "mine.py, line 1: ModuleNotFoundError",
}


@pytest.mark.parametrize("text", BROKEN_MODELS)
def test_a_broken_model_file_is_one_line(colias_here, text):
    (colias_here.folder / "mine.py").write_text(text)
    done = colias_here("run", "speed", "--model", "mine.py")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert BROKEN_MODELS[text] in done.stderr


def write_model(colias, instead: str, name: str = "my_model.py") -> None:
    """The model of docs/your-own-model.md, with ``instead`` before it takes its gradients."""
    text = user_files.MODEL.replace("        down, right", f"        {instead}\n        down, right")
    (colias.folder / name).write_text(text)


BREAKS = {
    "if now.mean() > 0: raise ValueError('odd')": "ValueError: odd",
    "class Two(Exception):\n            def __init__(self, a, b): super().__init__(a)\n"
    "        raise Two('needs', 'both')": "Two: needs",
    "raise SystemExit(3)": "SystemExit: 3",
    "raise RuntimeError": "RuntimeError",
    "raise ValueError('a :-1: b [b]c[/b]')": "ValueError: a :-1: b [b]c[/b]",
    "return None": "AnswerError: in frame 0, the answer is a NoneType without hs: expected a dsnn.Response",
    "return Response(float('nan'), 0.0, 0, 0)": "AnswerError: in frame 0, hs is nan: expected a finite number up to"
    " 1e+09 in size",
}


def reason_of(place: int, path: Path) -> str:
    """Why the model in ``path`` breaks: what it raises itself with the file and the line."""
    instead, reason = list(BREAKS.items())[place]
    if not any(word in instead for word in ("raise ", "raise(")):
        return reason
    lines = path.read_text().splitlines()
    raised = next(number for number, line in enumerate(lines, 1) if "raise " in line and line.strip() in instead)
    return f"{path.name}, line {raised}: {reason}"


def test_models_that_break_cost_the_others_nothing(colias):
    """Whatever they raise or answer, even what cannot travel between processes; the last that is shown is whole."""
    flags = ["--model", "dsnn"]
    for place, instead in enumerate(BREAKS):
        write_model(colias, instead, f"broken{place}.py")
        path = colias.folder / f"broken{place}.py"
        path.write_text(path.read_text().replace('"gradient"', f'"gradient{place}"'))
        flags += ["--model", path.name]
    done = colias(
        "run", "speed", *QUICK[:2], "--repeats", "1", "--no-recordings", *flags, "--model", "emd", "--out", "out"
    )
    assert done.returncode == 1, done.stderr
    reasons = [reason_of(place, colias.folder / f"broken{place}.py") for place in range(len(BREAKS))]
    for place, reason in enumerate(reasons):
        assert f"gradient{place} failed in trial 0 (translation rightward, 20 cm/s at 8 cm): {reason}" in done.stderr
    assert "Traceback" not in done.stderr
    rows = pq.read_table(colias.folder / "out" / "trials.parquet").to_pylist()
    assert [(row["trial"], row["model"]) for row in rows] == [(0, "dsnn"), (0, "emd"), (1, "dsnn"), (1, "emd")]
    failures = json.loads((colias.folder / "out" / "failures.json").read_text())
    assert [(f["trial"], f["model"], f["reason"]) for f in failures] == [
        (trial, f"gradient{place}", reason) for trial in range(2) for place, reason in enumerate(reasons)
    ]


def test_trials_without_a_working_model_fail_and_resume(colias):
    write_model(colias, "if frame[0, 0] >= 0: raise ValueError('odd')")
    arguments = ("run", "speed", *QUICK, "--only", "--model", "my_model.py", "--workers", "0")
    done = colias(*arguments, "--out", "out")
    assert done.returncode == 1 and "trial 3 failed (translation rightward, 30 cm/s at 8 cm)" in done.stderr
    assert "figure.png" not in done.stdout, "there is none to name"
    assert pq.read_table(colias.folder / "out" / "trials.parquet").num_rows == 0
    again = colias(*arguments, "--out", "out")
    assert again.returncode == 1 and again.stderr.count(": ValueError: odd") == 4


def test_a_claim_says_how_many_trials_it_lost(colias):
    write_model(colias, "if now.std() > 0 and int(now.sum()) % 5 == 0: raise ValueError('five')")
    flags = ("--model", "dsnn", "--model", "my_model.py", "--workers", "0")
    colias("run", "speed", *QUICK, *flags, "--out", "out")
    failed = len(json.loads((colias.folder / "out" / "failures.json").read_text()))
    claims = json.loads((colias.folder / "out" / "claims.json").read_text())["claims"]
    assert failed > 0
    for claim in claims:
        assert (f"{failed} trials of the run failed" in claim["outcome"]["measured"]) == (claim["model"] == "gradient")


def test_a_model_without_a_threshold_is_drawn_but_not_judged(colias):
    text = user_files.MODEL.replace("    t_sp: float = 0.2  # threshold on the potential\n", "")
    (colias.folder / "my_model.py").write_text(text.replace("self.parameters.t_sp", "9.0"))
    done = colias("run", "speed", *QUICK, "--only", "--model", "my_model.py", "--workers", "0", "--out", "out")
    assert done.returncode == 0, done.stderr
    claims = json.loads((colias.folder / "out" / "claims.json").read_text())["claims"]
    assert {claim["outcome"]["verdict"] for claim in claims} == {"not shown"}
    assert all(claim["outcome"]["measured"].startswith("this model does not spike: ") for claim in claims)
    assert "T =" not in (colias.folder / "out" / "figure.svg").read_text()


def test_parameters_that_make_themselves_travel_too(colias):
    """A field that is not given but computed: workers have to be able to make the parameters anew."""
    text = user_files.MODEL.replace("from dataclasses import dataclass", "from dataclasses import dataclass, field")
    text = text.replace(
        "    gain: float = 0.05\n",
        "    gain: float = 0.05\n    twice: float = field(init=False, default=0.0)\n\n"
        "    def __post_init__(self):\n        object.__setattr__(self, 'twice', 2 * self.gain)\n\n",
    )
    (colias.folder / "my_model.py").write_text(text)
    flags = ("--only", "--model", "my_model.py", "--set", "gradient.gain=0.1")
    done = colias("run", "speed", *QUICK, *flags, "--out", "out")
    assert done.returncode == 0, done.stderr
    described = json.loads((colias.folder / "out" / "experiment.json").read_text())
    assert described["settings"]["models"][0]["network"]["twice"] == 0.2
    assert len(described["files"]) == 1
