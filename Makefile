# `make run` and `make test` do all set-up by themselves; see tools/setup.sh.
BIN := .venv/bin
READY := .venv/.ready
# Some images set it. Every process, of which the tests start hundreds, would then compile all of the source anew.
unexport PYTHONDONTWRITEBYTECODE

# The figures that documentation quotes are checked by `release`, as `test` runs no hours of trials.
.PHONY: run reproduce numbers fidelity release hero train policies test test-train test-fit test-live test-swarm fuzz docs docs-quick playground lint types bench sizes setup lock clean

run: $(READY) ## The main job: the paper's speed tests, 40 trials
	$(BIN)/colias run speed

reproduce: $(READY) ## The paper's robot experiments, and which of its claims hold
	$(BIN)/colias reproduce

NUMBERS := runs/numbers
numbers: $(READY) ## The documentation's measured figures anew: the whole reproduction (NUMBERS=DIR goes on with one), then the text
	$(BIN)/colias reproduce --full --out $(NUMBERS)
	$(BIN)/python -m tools.results reproduction $(NUMBERS)

fidelity: $(READY) ## The claims about the robot with other cameras, drives and steps a second, hours; a later make numbers takes them over
	$(BIN)/colias sweep fidelity --out $(NUMBERS)/fidelity
	$(BIN)/colias sweep why --seed 1000 --out $(NUMBERS)/why

HERO := runs/hero
hero: $(READY) ## The first picture of README and site, docs/hero.webp, from a run that docs/sources.json notes; it opens in mid-crossing
	rm -f docs/hero.webp
	$(BIN)/colias run speed --repeats 1 --quiet --out $(HERO)
	$(BIN)/colias video $(HERO) --trial 2 --out docs/hero.webp --size 960x540 --fps 10 --speed 0.4 --quiet
	$(BIN)/python -c "from PIL import Image, ImageSequence; path = 'docs/hero.webp'; \
		frames = [frame.copy() for frame in ImageSequence.Iterator(Image.open(path))]; half = len(frames) // 2; \
		frames[half].save(path, save_all=True, append_images=frames[half + 1:] + frames[:half], duration=100, loop=0, quality=80)"
	$(BIN)/python -m tools.results take $(HERO) hero.webp

train: $(READY) ## A policy by PPO on neural observations, after setting up the extra [train]
	sh tools/setup.sh --train
	$(BIN)/colias train

policies: $(READY) ## Policies of five training seeds in either env and their tables, after setting up the extra [train]; some half an hour
	sh tools/setup.sh --train
	$(BIN)/colias train --env Optomotor --seeds 5
	$(BIN)/colias train --env Fixation --seeds 5

test: $(READY) ## Every test; those that need Debian's chromium, mesa-vulkan-drivers, gcc-arm-none-eabi or qemu-system-arm are skipped where these cannot be had
	sh tools/setup.sh --browser
	sh tools/setup.sh --viewer
	sh tools/setup.sh --firmware
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

PYTHONS :=
release: $(READY) ## The source distribution and the wheel, into dist/, checked and tried in empty environments; refused while the documentation shows what is stale
	sh tools/setup.sh --fit
	$(BIN)/python -m tools.results check
	sh tools/setup.sh --release
	$(BIN)/python -m tools.release $(PYTHONS)

SITE := build/site
SPHINX := $(BIN)/sphinx-build -b html --keep-going -q -j auto
OPEN := docs: open $(CURDIR)/$(SITE)/index.html
docs: $(READY) ## The documentation, into build/site: tutorials executed, warnings are errors, links and search checked
	@echo "docs: 3 to 4 minutes of processor time, and the first time 160 MB of packages (make docs-quick: 1, nothing checked)"
	sh tools/setup.sh --docs
	sh tools/setup.sh --fit
	sh tools/setup.sh --browser
	sh tools/setup.sh --node
	rm -rf $(SITE) docs/generated
	$(SPHINX) -W docs $(SITE)
	$(BIN)/python -m pytest -m site tests/site
	@echo "$(OPEN)"

docs-quick: $(READY) ## The same to read: nothing checked, tutorials without their results
	@echo "docs-quick: 1 minute of processor time, and the first time 160 MB of packages"
	sh tools/setup.sh --docs
	rm -rf $(SITE) docs/generated
	$(SPHINX) -D nb_execution_mode=off -D suppress_warnings=misc.highlighting_failure,mystnb.glue docs $(SITE)
	@echo "$(OPEN)"

playground: ## The playground's JavaScript: linted, its format and its types checked (npm fetches the tools)
	sh tools/setup.sh --node
	cd tools/playground && npm install --silent && npm run --silent check

test-fit: $(READY) ## The tests of fits, which need the extra [fit]
	sh tools/setup.sh --fit
	$(BIN)/python -m pytest tests/experiments/kinds/test_fit.py

test-live: $(READY) ## The tests of the page of colias live, which need the extra [live] and Chromium
	sh tools/setup.sh --live
	sh tools/setup.sh --browser
	$(BIN)/python -m pytest tests/experiments/live

test-swarm: $(READY) ## The tests of swarms as agents, which need the extra [swarm]
	sh tools/setup.sh --swarm
	$(BIN)/python -m pytest tests/colias_sim/envs/test_swarm.py

test-train: $(READY) ## The tests of training, those too that need the extra [train]
	sh tools/setup.sh --train
	$(BIN)/python -m pytest tests/experiments/kinds/test_training.py tests/dsnn/test_adapters.py tests/docs/test_docs_vision.py

fuzz: $(READY) ## The network and the chip's records in C under the sanitizers: 2,000 cases
	COLIAS_FUZZ_CASES=2000 $(BIN)/python -m pytest tests/dsnn/test_native.py tests/experiments/robot/test_serial.py \
		-k "every_build or records_in_c"

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -m tools.sizes --check

types: $(READY)
	$(BIN)/mypy

bench: $(READY) ## Speed, as ratios measured side by side
	$(BIN)/python -m benchmarks

sizes: $(READY) ## Code lines, files, record types, public names and options by budget
	$(BIN)/python -m tools.sizes

setup: $(READY)

$(READY): requirements.lock pyproject.toml tools/setup.sh $(wildcard dsnn/native/*.[ch] dsnn/native/binding.py dsnn/native/CMakeLists.txt)
	sh tools/setup.sh

lock: $(READY) ## Renew requirements.lock from pyproject.toml (needs uv)
	uv pip compile pyproject.toml --extra cluster --group dev --universal --generate-hashes --no-header --no-annotate \
		--python-version 3.11 --upgrade -q -o requirements.lock
	uv pip compile --group docs -c requirements.lock --universal --generate-hashes --no-header \
		--no-annotate --python-version 3.11 --upgrade -q -o docs/requirements.lock
	uv pip compile --group release --universal --generate-hashes --no-header --no-annotate --python-version 3.11 \
		--upgrade -q -o tools/release.lock

clean:
	rm -rf .venv build docs/generated .pytest_cache .mypy_cache .ruff_cache .hypothesis
