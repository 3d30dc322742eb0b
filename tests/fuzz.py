"""Look for inputs that a reader ends with anything but a plausible result or one line.

A fuzzer guided by coverage (atheris, libFuzzer) changes inputs, and keeps those that reach new
lines of the readers. Needs the extra ``dev`` on Linux::

    python tests/fuzz.py text             # for a minute
    python tests/fuzz.py motion_bids 3600
    python tests/fuzz.py all 36000        # all targets in turn, as long in total
    python tests/fuzz.py all 60 FOLDER 1  # in another folder than fuzzed; the same inputs each time

Starts from ``tests/corpus/TARGET`` and from what earlier runs kept in ``fuzzed/TARGET/kept``. Each
kind of fault is printed once, with the file of its input in ``fuzzed/TARGET``; the status is then
1. An input that ends the process, takes over a minute or more than 4 GB is the file
``crash-...``, ``timeout-...`` or ``oom-...`` there.
"""

import os
import re
import sys
import time
from hashlib import sha256
from pathlib import Path

TESTS = Path(__file__).resolve().parent
ROOT = TESTS.parent
# before the folder of this file, which has a folder narx as well
sys.path.insert(0, str(ROOT))

import atheris  # noqa: E402
from fuzz_mutations import mutated  # noqa: E402

# the readers and what decides on their data; compiled code and torch are not instrumented
_ROOMS = ("datasets.", "recordings.", "calibration.", "settings.", "experiments.configuration.")
_FILES = (
    "inference.checkpoint",
    "inference.start_up",
    "inference.predict",
    "experiments.overrides",
)
_LONGEST_S, _MEMORY_MB, _LONGEST_INPUT = 60, 4096, 30_000


def not_instrumented() -> list[str]:
    """List the modules of the package whose coverage does not guide the fuzzer."""
    every = [
        ".".join(Path(folder, file).relative_to(ROOT).with_suffix("").parts)
        for folder, _, files in os.walk(ROOT / "narx", followlinks=True)
        for file in files
        if file.endswith(".py")
    ]
    wanted = tuple(f"narx.{name}" for name in (*_ROOMS, *_FILES))
    return [name.removesuffix(".__init__") for name in every if not name.startswith(wanted)]


# what is read may take a quarter of the memory that ends the process
os.environ |= {"NARX_MAX_MEMORY_MIB": str(_MEMORY_MB // 4), "OMP_NUM_THREADS": "1"}
with atheris.instrument_imports(include=["narx"], exclude=not_instrumented()):
    import fuzz_targets


def fuzz(target: str, seconds: int, folder: Path, seed: int) -> None:
    """Run one target, with inputs drawn from the seed or, if 0, from the time; does not return."""
    kept = folder / "kept"
    kept.mkdir(parents=True, exist_ok=True)
    for name, content in fuzz_targets.whole_files(target).items():
        (kept / name).write_bytes(content)
    seen: set[str] = set()

    def run(data: bytes) -> None:
        wrong = fuzz_targets.outcome(target, data, folder / "scratch" / "input")
        if wrong is None:
            return
        # the same line of the package, or the same words
        kind = re.sub(r"[\d.]+", "0", wrong.rpartition(" at ")[2] or wrong)[:80]
        if kind not in seen:
            seen.add(kind)
            file = folder / f"fault-{sha256(data).hexdigest()[:12]}"
            file.write_bytes(data)
            print(f"{target}: {wrong[:300]} ({file})", flush=True)

    options = [
        f"-max_total_time={seconds}", f"-artifact_prefix={folder}/", f"-timeout={_LONGEST_S}",
        f"-rss_limit_mb={_MEMORY_MB}", f"-max_len={_LONGEST_INPUT}", "-print_final_stats=1",
        f"-seed={seed}",
    ]  # fmt: skip
    corpus = TESTS / "corpus" / target
    atheris.Setup([sys.argv[0], *options, str(kept), str(corpus)], run, custom_mutator=mutated)
    atheris.Fuzz()


def main(target: str, seconds: str = "60", folder: str = "fuzzed", seed: str = "0") -> int:
    """Run one target or all of them, each in a process of its own."""
    if target not in ("all", *fuzz_targets.TARGETS):
        print(f"no target '{target}': all, {', '.join(fuzz_targets.TARGETS)}", file=sys.stderr)
        return 2
    chosen = list(fuzz_targets.TARGETS) if target == "all" else [target]
    faults = 0
    for one in chosen:
        place, begun = Path(folder).resolve() / one, time.time()
        place.mkdir(parents=True, exist_ok=True)
        log = place / "log.txt"
        # libFuzzer ends its process; the imports, which take the longest, are shared
        process = os.fork()
        if process == 0:
            with log.open("w") as stream:
                os.dup2(stream.fileno(), sys.stderr.fileno())
            fuzz(one, max(1, int(seconds) // len(chosen)), place, int(seed))
        os.waitpid(process, 0)
        said = log.read_text(errors="replace")
        done = re.search(r"number_of_executed_units: (\d+)", said)
        new = [path for path in sorted(place.glob("*-*")) if path.stat().st_mtime >= begun]
        faults += len(new) + (done is None)
        count = f"{done[1]} inputs" if done else f"stopped, {said.strip().splitlines()[-1:]}"
        print(f"{one}: {count}, {len(new)} faults", *new, flush=True)
    return int(faults > 0)


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
