"""Every command that the README and the pages show is accepted as it is written there."""

import re
import shlex
from pathlib import Path

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import IntervalSweep

from narx.experiments.configuration.schemas import SCHEMAS

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PYTHON_BLOCK = re.compile(r"^```python\n.*?^```", re.MULTILINE | re.DOTALL)
# alone on its line, or in backquotes
COMMAND = re.compile(
    r"(?:^\s*|`)((?:narx-|python -m (?:narx\.)?experiments\.|python (?=docs/|tests/))[^`\n]+)",
    re.MULTILINE,
)
NAME = re.compile(r"narx-([a-z-]+)|python -m (?:narx\.)?experiments\.([a-z_]+)|python (\S+\.py)")


def _commands():
    """Yield page, name of the command or file of the script, and its arguments."""
    found = set()
    for page in PAGES:
        text = PYTHON_BLOCK.sub("", page.read_text(encoding="utf-8")).replace("\\\n", " ")
        for line in COMMAND.findall(text):
            name = NAME.match(line)
            if name is not None:
                command = (name[1] or name[2] or name[3]).replace("-", "_")
                arguments = tuple(shlex.split(line[name.end() :], comments=True))
                found.add((str(page.relative_to(ROOT)), command, arguments))
    return sorted(found)


COMMANDS = _commands()
# these two have arguments, but no configuration
KNOWN = {*SCHEMAS, "compare", "embedded"}


def test_the_pages_show_commands_of_every_kind():
    assert len(COMMANDS) > 60
    shown = {command for _, command, _ in COMMANDS}
    assert shown > {"train", "benchmark", "export", "predict", "draft_study", "compare"}
    scripts = {str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.py")}
    # the site is built with it, no reader runs it
    assert scripts - {"docs/reference.py", "docs/house.py"} <= shown


def _one_run(override):
    """Take the first value of a sweep."""
    parsed = OverridesParser.create().parse_override(override)
    if not parsed.is_sweep_override():
        return override
    if isinstance(parsed.value(), IntervalSweep):
        return f"{parsed.get_key_element()}={parsed.value().start}"
    return f"{parsed.get_key_element()}={next(parsed.sweep_string_iterator())}"


def test_every_command_and_script_exists():
    for page, command, _ in COMMANDS:
        found = (ROOT / command).is_file() if command.endswith(".py") else command in KNOWN
        assert found, f"{page}: {command}"


# a configuration of the reader's own is in the page's blocks, which are not files here
CONFIGURED = sorted(
    {(c, a) for _, c, a in COMMANDS if c in SCHEMAS and not {"--config-dir", "--help"} & set(a)}
)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "arguments"), CONFIGURED)
def test_a_command_is_accepted(command, arguments, compose_checked):
    overrides = [_one_run(one) for one in arguments if one != "-m"]
    assert compose_checked(command, *[one for one in overrides if not one.startswith("hydra")])
