"""User models that do everything a model should not."""

from __future__ import annotations

from tests.attack.model_files import KILLS, LOST, REFUSED, WORKS, Case, case, model_text

LOOMING = "answer = Response(looming=0.5 + abs(hs) / 2, looming_spikes=abs(count(hs)))"
ONLY_LOOMING = ', channels=("looming",)'

TWIN = case("twin", WORKS)
LOOMING_TWIN = case("looming-twin", WORKS, step=LOOMING, entry=ONLY_LOOMING)

RAISING = (
    case("raises-in-build", LOST, build="raise ValueError('odd')"),
    case("raises-in-reset", LOST, WORKS, reset="raise ValueError('odd')"),
    case("raises-at-0", LOST, step="if n == 0: raise ValueError('odd')"),
    case("raises-at-5", LOST, step="if n == 5: raise KeyError('odd')"),
    case("raises-at-last", LOST, step="if n == LAST: raise ValueError('odd')"),
    case("raises-bare", LOST, step="raise RuntimeError"),
    case("raises-assert", LOST, step="assert n < 3"),
    case("raises-system-exit", LOST, step="sys.exit(3)"),
    case("raises-system-exit-0", LOST, step="sys.exit()"),
    case("raises-system-exit-in-build", LOST, build="sys.exit(0)"),
    case("raises-generator-exit", LOST, step="raise GeneratorExit"),
    case("raises-stop-iteration", LOST, step="if n == 4: raise StopIteration"),
    case("raises-keyboard-interrupt", LOST, step="if n == 4: raise KeyboardInterrupt"),
    case("raises-keyboard-interrupt-in-build", LOST, build="raise KeyboardInterrupt"),
    case("raises-base-exception", LOST, step="if n == 4: raise BaseException('bare bones')"),
    case(
        "raises-group",
        LOST,
        step="if n == 4: raise BaseExceptionGroup('two', [ValueError('a'), KeyboardInterrupt()])",
    ),
    case("raises-memory-error", LOST, step="if n == 4: raise MemoryError"),
    case("raises-os-error", LOST, step="if n == 4: raise FileNotFoundError(2, 'No such file', 'weights.npz')"),
    case("raises-broken-pipe", LOST, step="if n == 4: raise BrokenPipeError(32, 'Broken pipe')"),
    case(
        "raises-unpicklable",
        LOST,
        top="class Two(Exception):\n    def __init__(self, a, b):\n        super().__init__(a)\n"
        "        self.f = lambda: b",
        step="raise Two('needs', 'both')",
    ),
    case(
        "raises-unspeakable",
        LOST,
        top="class Dumb(Exception):\n    def __str__(self):\n        raise ValueError('no words')\n"
        "    __repr__ = __str__",
        step="raise Dumb",
    ),
    case("raises-huge", LOST, step="if n == 4: raise ValueError('x' * 3_000_000)"),
    case("raises-lines", LOST, step="if n == 4: raise ValueError('first\\n\\n  second\\r\\nthird\\x1b[31m red \\x07')"),
    case("raises-markup", LOST, step="if n == 4: raise ValueError('[/foo] [b]bold[/b] [red] <b>fat')"),
    case("raises-surrogate", LOST, step="if n == 4: raise ValueError('half a \\udc80 letter')"),
    case("raises-warning", LOST, WORKS, step="import warnings\nwarnings.warn('odd', stacklevel=1)"),
    case("recurses", LOST, top="def deep(i):\n    return deep(i + 1)", step="if n == 4: deep(0)"),
)

ANSWERS = (
    ("none", "answer = None"),
    ("dict", "answer = {'hs': hs, 'vs': vs}"),
    ("tuple", "answer = (hs, vs, 0, 0)"),
    ("number", "answer = hs"),
    ("class", "answer = Response"),
    ("hs-vector", "answer = replace(answer, hs=np.array([hs, hs]))"),
    ("hs-vector-of-1", "answer = replace(answer, hs=np.array([hs]))"),
    ("hs-list", "answer = replace(answer, hs=[hs])"),
    ("hs-string", "answer = replace(answer, hs=str(hs))"),
    ("hs-none", "answer = replace(answer, hs=None)"),
    ("hs-complex", "answer = replace(answer, hs=complex(hs, 1.0))"),
    ("hs-nan-at-0", "if n == 0: answer = replace(answer, hs=float('nan'))"),
    ("hs-nan-at-last", "if n == LAST: answer = replace(answer, hs=np.nan)"),
    ("vs-inf", "if n == 5: answer = replace(answer, vs=-np.inf)"),
    ("hs-masked", "if n == 5: answer = replace(answer, hs=np.ma.masked)"),
    ("hs-object", "if n == 5: answer = replace(answer, hs=object())"),
    ("hs-huge-int", "answer = replace(answer, hs=10**400)"),
    ("spikes-1.5", "answer = replace(answer, hs_spikes=1.5)"),
    ("spikes-nan", "answer = replace(answer, hs_spikes=float('nan'))"),
    ("spikes-2**70", "answer = replace(answer, hs_spikes=2**70)"),
    ("spikes-2**62", "answer = replace(answer, hs_spikes=2**62)"),
    ("spikes-1e30", "answer = replace(answer, hs_spikes=1e30)"),
    ("spikes-string", "answer = replace(answer, hs_spikes='1')"),
    ("spikes-none", "answer = replace(answer, hs_spikes=None)"),
    ("spikes-vector", "answer = replace(answer, vs_spikes=np.array([1, 1]))"),
)
"""What is no answer: each is a model that loses its part."""

WRONG = tuple(case(f"answers-{name.replace('**', '-to-')}", LOST, step=step) for name, step in ANSWERS)

ODD = (
    case("answers-alike", WORKS, LOST,
         step="answer = SimpleNamespace(**{f.name: getattr(answer, f.name) for f in dataclasses.fields(Response)})"),
    case("answers-without-looming", WORKS, LOST,
         step="answer = SimpleNamespace(hs=hs, vs=vs, hs_spikes=count(hs), vs_spikes=count(vs))"),
    case("answers-subclass", WORKS, top="class Mine(Response):\n    pass",
         step="answer = Mine(hs, vs, count(hs), count(vs))"),
    case(
        "answers-by-a-property-that-raises", LOST,
        top="class Mine:\n    vs = looming = 0.0\n    hs_spikes = vs_spikes = looming_spikes = 0\n    maps = None\n"
        "    @property\n    def hs(self):\n        raise RuntimeError('not today')",
        step="answer = Mine()",
    ),
    case(
        "answers-the-same-object", WORKS, LOST,
        build="self.answer = SimpleNamespace(maps=None, looming=0.0, looming_spikes=0, azimuth=0.0)",
        step="answer = self.answer\nanswer.hs, answer.vs = hs, vs\n"
        "answer.hs_spikes, answer.vs_spikes = count(hs), count(vs)",
    ),
    case(
        "answers-the-same-array", WORKS, LOST,
        build="self.out = np.zeros(2)",
        step="self.out[:] = hs, vs\nanswer = replace(answer, hs=self.out[:1].reshape(()), vs=self.out[1:].reshape(()))",
    ),
    case("hs-0-d", WORKS, LOST, step="answer = replace(answer, hs=np.array(hs))"),
    case("hs-float32", WORKS, close=1e-6, step="answer = replace(answer, hs=np.float32(hs))"),
    case("hs-float16", WORKS, LOST, close=1e-2, step="answer = replace(answer, hs=np.float16(hs))"),
    case("hs-decimal", WORKS, LOST, top="from decimal import Decimal", step="answer = replace(answer, hs=Decimal(hs))"),
    case("hs-1e308", WORKS, LOST, twin=None, step="answer = replace(answer, hs=1e308 if n % 2 else -1e308)"),
    case("hs-bool", WORKS, LOST, twin=None, step="answer = replace(answer, hs=hs > 0)"),
    case("spikes-int8", WORKS, step="answer = replace(answer, hs_spikes=np.int8(count(hs)))"),
    case("spikes-2.0", WORKS, LOST, step="answer = replace(answer, hs_spikes=np.float64(count(hs)))"),
    case("spikes-uint8", WORKS, LOST, twin=None, step="answer = replace(answer, hs_spikes=np.uint8(abs(count(hs))))"),
    case("azimuth-nan", WORKS, LOST, step="answer = replace(answer, azimuth=float('nan'))"),
    case("looming-nan-unasked", WORKS, LOST, step="answer = replace(answer, looming=float('nan'))"),
    case("looming-that-fills-hs", WORKS, LOST, twin="looming-twin", ignore="hs", entry=ONLY_LOOMING,
         step=LOOMING + "\nanswer = replace(answer, hs=hs, hs_spikes=3)"),
    case("looming-negative-spikes", LOST, entry=ONLY_LOOMING, step="answer = Response(looming=0.7, looming_spikes=-1)"),
    case("direction-that-looms", WORKS, LOST, ignore="looming",
         step="answer = replace(answer, looming=0.9, looming_spikes=5)"),
    case("without-reset", WORKS, LOST, make="lambda s, p: SimpleNamespace(step=Model(s, p).step)"),
    case("without-maps-keyword", WORKS, LOST,
         make="lambda s, p: (lambda m: SimpleNamespace(reset=m.reset, shape=s, step=lambda frame: m.step(frame)))"
         "(Model(s, p))"),
    case("build-answers-none", LOST, REFUSED, make="lambda s, p: None"),
    case("build-answers-a-class", LOST, REFUSED, make="lambda s, p: Model"),
    case("build-takes-nothing", LOST, REFUSED, make="lambda: Model"),
    case("build-is-a-lambda", WORKS, make="lambda s, p: Model(s, p)"),
)  # fmt: skip

MUTATING = (
    case("sets-frame", LOST, WORKS, step="frame[:] = 0"),
    case("adds-to-frame", LOST, WORKS, step="frame += np.uint8(17)"),
    case("sorts-frame", LOST, WORKS, step="frame.sort()"),
    case("blurs-frame", LOST, WORKS, top="import cv2", step="cv2.GaussianBlur(frame, (0, 0), 5, dst=frame)"),
    case("thresholds-frame", LOST, WORKS, top="import cv2",
         step="cv2.threshold(frame, 100, 255, cv2.THRESH_BINARY, dst=frame)"),
    case("unlocks-frame", LOST, WORKS, step="frame.setflags(write=True)\nframe[:] = 0"),
    case("writes-through-base", LOST, WORKS, step="""
        below = frame
        while below is not None:
            try:
                np.asarray(below)[...] = 0
            except (TypeError, ValueError):
                pass
            below = getattr(below, "base", None)
    """),
    case("writes-through-a-view", LOST, WORKS, step="np.asarray(frame).reshape(-1)[::2] = 0"),
    case("writes-through-its-address", LOST, WORKS, step="""
        if frame.flags.c_contiguous and frame.flags.owndata:
            ctypes.memset(frame.ctypes.data, 0, frame.nbytes)
    """),
    case("reshapes-frame", LOST, WORKS, step="frame.shape = (-1,)"),
    case("retypes-frame", LOST, WORKS, step="frame.dtype = np.int8"),
    case("resizes-frame", LOST, WORKS, step="frame.resize((2, 2), refcheck=False)"),
    case("changes-frames-later", LOST, WORKS, build="self.kept = []", step="""
        for old in self.kept:
            if old.flags.writeable:
                old[:] = 255
        self.kept.append(frame)
    """),
    case("changes-frames-from-a-thread", LOST, WORKS, build="""
        self.kept = []
        def spoil():
            for _ in range(3000):
                for old in list(self.kept):
                    if old.flags.writeable:
                        old[:] = 255
                time.sleep(0.001)
        threading.Thread(target=spoil, daemon=True).start()
    """, step="self.kept.append(frame)"),
)  # fmt: skip
"""Whatever they do to their frame, the others' frames, and those in recordings, are what the camera saw."""

MEDDLING = (
    case("prints", WORKS, step="print('[b]noise[/b] of the model')\nprint('and errors', file=sys.stderr)"),
    case("writes-to-fd-1", WORKS, step="os.write(1, b'raw\\n')\nos.write(2, b'raw too\\n')"),
    case("sleeps-50-ms", WORKS, step="time.sleep(0.05)"),
    case("keeps-300-mb", WORKS, build="self.hoard = np.ones((300, 1 << 20), np.uint8)"),
    case("changes-folder", WORKS, LOST, step="os.chdir('/')"),
    case("raises-on-float-errors", WORKS, LOST, step="np.seterr(all='raise')"),
    case("seeds-numpy", WORKS, step="np.random.seed(1)\nimport random\nrandom.seed(1)"),
    case("turns-opencv-off", WORKS, LOST, top="import cv2",
         step="cv2.setUseOptimized(False)\ncv2.setNumThreads(8)\ncv2.setRNGSeed(3)"),
    case("ignores-signals", WORKS, LOST, build="""
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    """),
    case("changes-locale", WORKS, top="import locale", step="locale.setlocale(locale.LC_ALL, 'C.utf8')"),
    case("breaks-the-environment", WORKS, LOST,
         step="os.environ.update(MUJOCO_GL='nonsense', DISPLAY=':77', PYTHONPATH='', PATH='')"),
    case("empties-the-environment", WORKS, LOST, step="os.environ.clear()"),
    case("stops-the-clock", WORKS, LOST, step="time.perf_counter = time.time = lambda: 0.0"),
    case("sets-print-options", WORKS, step="np.set_printoptions(precision=1, threshold=2)\nsys.setrecursionlimit(400)"),
    case("turns-warnings-to-errors", WORKS, LOST, step="import warnings\nwarnings.simplefilter('error')"),
    case("switches-off-gc", WORKS, step="import gc\ngc.disable()"),
    case("starts-a-thread", WORKS,
         step="if n == 0: threading.Thread(target=time.sleep, args=(600,), daemon=True).start()"),
    case("starts-a-thread-that-holds", WORKS, step="if n == 0: threading.Thread(target=time.sleep, args=(3,)).start()"),
    case("starts-a-program", WORKS, leaves="sleep 77",
         step="if n == 0: self.program = subprocess.Popen(['sleep', '77'])"),
    case("registers-an-exit", WORKS, top="import atexit", step="if n == 0: atexit.register(lambda: None)"),
    case("reads-stdin", WORKS, LOST, step="if n == 0: input()"),
    case("sleeps-at-import", WORKS, top="time.sleep(0.4)"),
    case("prints-at-import", WORKS, top="print('hello from the file')"),
)  # fmt: skip

ALONE = (
    case("forks", WORKS, LOST, top="DONE = []", step="""
        if n == 3 and not DONE:
            DONE.append(1)
            os.fork()
    """),
    case("forks-and-sleeps", WORKS, LOST, top="DONE = []", step="""
        if n == 3 and not DONE:
            DONE.append(1)
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
    """),
    case("closes-sys-stdout", WORKS, LOST, step="sys.stdout.close()"),
    case("replaces-sys-stdout", WORKS, LOST, step="sys.stdout = sys.stderr = None"),
    case("closes-fd-1", WORKS, LOST, step="if n == 3: os.close(1)"),
    case("closes-fd-2", WORKS, LOST, step="if n == 3: os.close(2)"),
)  # fmt: skip
"""What touches the process itself, or its streams: each is run alone beside the DSNN."""

KILLERS = (
    case("exits", KILLS, step="if frame.mean() < 128: os._exit(3)"),
    case("exits-with-0", KILLS, step="if frame.mean() < 128: os._exit(0)"),
    case("crashes", KILLS, step="if frame.mean() < 128: ctypes.string_at(0)"),
    case("kills-itself", KILLS, step="if frame.mean() < 128: os.kill(os.getpid(), signal.SIGKILL)"),
    case("aborts", KILLS, step="if frame.mean() < 128: os.abort()"),
)
"""They die of dark clips."""

NAMES = {
    "mathtext": r"$\frac{1}{0$", "closing-tag": "[/foo]", "tags": "[red]x[/red]", "unicode": "Grüße 目 🤖",
    "space": "two words", "dash": "--model", "percent": "100 %", "quote": "o'clock \"x\"", "equals": "a=b",
    "html": "<b>fat", "section": "camera",
}  # fmt: skip

NAMED = tuple(case(f"named-{name}", WORKS, REFUSED, label=label) for name, label in NAMES.items())

BAD_NAMES = {
    "none": None, "empty": "", "long": "x" * 5000, "slash": "a/b", "dots": "../up", "newline": "two\nlines",
    "number": 3,
    "nul": "a\0b", "surrogate": "\udc80", "escape": "a\x1b[31mb", "dsnn": "dsnn",
}  # fmt: skip

FILES = {
    "syntax-error": "def broken(:\n",
    "bytes-that-are-no-text": None,
    "nothing": "",
    "without-model": "x = 1\n",
    "model-of-a-wrong-type": "MODEL = 3\n",
    "model-is-a-class": "class MODEL:\n    pass\n",
    "raises-at-import": "raise ValueError('odd [/foo]\\nsecond line')\n",
    "exits-at-import": "import sys\nsys.exit(0)\n",
    "base-exception-at-import": "raise BaseException('bones')\n",
    "reads-stdin-at-import": "input('your name? ')\n",
    "imports-what-is-not-there": "import absent_module\n",
    "imports-itself-wrongly": "from dsnn import NoSuchThing\n",
    "recurses-at-import": "def f():\n    f()\nf()\n",
}

ENTRIES = {
    "channels-empty": ", channels=()",
    "channels-unknown": ", channels=('hs', 'smell')",
    "channels-twice": ", channels=('hs', 'hs')",
    "channels-a-string": ", channels='hs'",
    "channels-a-number": ", channels=3",
}

PARAMETERS = {
    "parameters-none": ("None", REFUSED),
    "parameters-a-dict": ("{'t_sp': 0.02}", REFUSED),
    "parameters-a-class": ("Parameters", REFUSED),
    "parameters-not-frozen": ("dataclass(type('P', (), {'__annotations__': {'t_sp': float}, 't_sp': 0.02}))()", WORKS),
    "parameters-with-an-array": (
        "dataclasses.make_dataclass('P', [('t_sp', float, 0.02), ('w', object, dataclasses.field(default_factory="
        "lambda: np.arange(3.0)))], frozen=True)()",
        WORKS,
    ),
    "parameters-with-a-lambda": (
        "dataclasses.make_dataclass('P', [('t_sp', float, 0.02), ('f', object, len)], frozen=True)()",
        WORKS,
    ),
    "threshold-nan": ("Parameters(float('nan'))", WORKS),
    "threshold-a-string": ("Parameters('high')", WORKS),
    "threshold-none": ("Parameters(None)", WORKS),
    "threshold-infinite": ("Parameters(float('inf'))", WORKS),
}


def _entry(name: str, entry: str) -> Case:
    return case(name, REFUSED, LOST, entry=entry) if "twice" in name else case(name, REFUSED, entry=entry)


def _with_parameters(name: str, parameters: str, best: str) -> Case:
    text = model_text(name).replace(", Parameters())", f", {parameters})")
    return case(name, REFUSED, *({best, LOST} - {REFUSED} if best != REFUSED else ()), text=text)


DECLARED_WRONG = (
    *(case(f"file-{name}", REFUSED, text="\udcff\udcfe" if text is None else text) for name, text in FILES.items()),
    *(
        Case(f"called-{name}", model_text(name).replace(f"ModelEntry({name!r}", f"ModelEntry({label!r}"),
             frozenset({REFUSED}), str(label), None, 0.0, "-", "")
        for name, label in BAD_NAMES.items()
    ),
    *(_entry(name, entry) for name, entry in ENTRIES.items()),
    *(_with_parameters(name, *given) for name, given in PARAMETERS.items()),
)  # fmt: skip
"""What is wrong with the declaration: each is a command of its own, as a refusal ends it."""

MAPS = {
    "maps-of-a-wrong-shape": "LayerMaps(*[np.zeros((2, 3))] * 4)",
    "maps-of-text": "LayerMaps('a', 'b', 'c', 'd')",
    "maps-none": "LayerMaps(None, None, None, None)",
    "maps-a-number": "3",
    "maps-nan": "LayerMaps(*[np.full(self.shape, np.nan)] * 4)",
    "maps-complex": "LayerMaps(*[np.zeros(self.shape, complex)] * 4)",
    "maps-of-objects": "LayerMaps(*[np.full(self.shape, None)] * 4)",
    "maps-now-and-then": "LayerMaps(*[np.zeros(self.shape)] * 4) if n % 2 else None",
}
MAPPED = tuple(
    case(name, WORKS, LOST, step=f"if maps: answer = replace(answer, maps={given})") for name, given in MAPS.items()
)

TOGETHER = (*RAISING, *WRONG, *ODD, *MUTATING, *MEDDLING)
"""Those that one run can show side by side: each may lose its own part alone."""

EVERY = (*TOGETHER, *ALONE, *KILLERS, *NAMED, *DECLARED_WRONG, *MAPPED)


def batches(cases: tuple[Case, ...], size: int) -> list[tuple[Case, ...]]:
    """The cases in groups for one run each, in order: kindred ones together."""
    return [cases[i : i + size] for i in range(0, len(cases), size)]
