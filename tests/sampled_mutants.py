"""Estimate the mutation score of a package from a random sample of its mutants.

All mutants of a package take mutmut hours. Here its operators list them, and a seeded sample is
run, each with the tests that mirror the package, those of the changed module first, until one
fails. Needs the extra ``mutation``::

    python tests/sampled_mutants.py kinematics [sample size] [seed]

Prints the mutants that survive, and the score with its 95 % interval (Clopper and Pearson). The
machine code of the kernels is used again: its stamp depends on their sources alone. For a mutant
of ``kernels`` itself all of them are compiled again, and a mutant that makes tests hang is stopped.
"""

import importlib
import itertools
import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from changed_lines import LIBRARIES, NOT_NOTICED, Change, copied_package, status_of_tests
from scipy import stats

_ROOT = Path(__file__).parents[1]
_ALSO = ("tests/narx/test_exports.py", "tests/test_snapshots.py")


def mutants(path: Path) -> Iterator[tuple[str, str]]:
    """Each mutant of a source file: description and changed source."""
    from mutmut.mutation.file_mutation import create_mutations

    source = path.read_text(encoding="utf-8")
    module, mutations, *_ = create_mutations(str(path), source)
    lines = source.splitlines()
    for mutation in mutations:
        changed = module.deep_replace(mutation.original_node, mutation.mutated_node).code
        pairs = itertools.zip_longest(lines, changed.splitlines(), fillvalue="")
        differing = (
            f"{number}: {before.strip()}  ->  {after.strip()}"
            for number, (before, after) in enumerate(pairs, 1)
            if before != after
        )
        yield next(differing, "nothing"), changed


def tests_of(path: Path, tests: Path) -> tuple[str, ...]:
    """Test files of the package, those that mirror the module first."""
    words = path.stem.split("_")

    def distance(file: Path) -> tuple[bool, bool, int]:
        name = file.stem.removeprefix("test_")
        return name != path.stem, not any(w in name for w in words), file.stat().st_size

    files = sorted(tests.rglob("test_*.py"), key=distance)
    return (*(str(file.relative_to(_ROOT)) for file in files), *_ALSO)


def main(package: str, size: str = "60", seed: str = "0") -> int:
    """Run a sample of the mutants of a package."""
    baselines = package == "baselines"
    sources = _ROOT / package if baselines else _ROOT / "narx" / package
    tests = _ROOT / "tests" / ("" if baselines else "narx") / package
    every = [(path, *mutant) for path in sorted(sources.rglob("*.py")) for mutant in mutants(path)]
    sample = random.Random(int(seed)).sample(every, min(int(size), len(every)))
    for library in LIBRARIES:
        importlib.import_module(library)
    noticed = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = copied_package(Path(folder))
        for n, (path, what, changed) in enumerate(sample, 1):
            file = str(path.relative_to(_ROOT))
            original = path.read_text(encoding="utf-8")
            chosen = ("-m", "not slow", *tests_of(path, tests))
            status = status_of_tests(Change(what, file, original, changed, chosen), copy)
            noticed += status != NOT_NOTICED
            if status == NOT_NOTICED:
                print(f"survives: {file}:{what}", flush=True)
            if n % 10 == 0 or n == len(sample):
                share = 100 * noticed / n
                low, high = stats.binomtest(noticed, n).proportion_ci()
                print(
                    f"{package}: {noticed} of {n} mutants noticed, {share:.0f} % (95 % interval "
                    f"{100 * low:.0f} to {100 * high:.0f} %); {len(every)} mutants in all",
                    flush=True,
                )
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
