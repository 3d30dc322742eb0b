"""The text of `--help`: purpose and examples of a command, and the meaning of every key.

Both are read from the comments of the configuration files, so help and comments always agree.
"""

from pathlib import Path

from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, ListConfig, OmegaConf

_CONFIGS = Path(__file__).parents[1] / "configs"
# the only experiment without walks to train on
_NOT_FOR = {"train": {"tham_as_printed"}}


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def _is_heading(line: str) -> bool:
    return line.startswith("#") and not line.startswith("# @package")


def _heading(path: Path) -> str:
    heading = []
    for line in _lines(path):
        if not line.startswith("#"):
            break
        if _is_heading(line):
            heading.append(line.removeprefix("#").removeprefix(" "))
    return "\n".join(heading)


def _body(path: Path) -> str:
    lines = _lines(path)
    while lines and lines[0].startswith("#"):
        lines.pop(0)
    body, skipping = [], False
    for line in lines:
        # the keys that compose the file are not keys of the command
        if not line.startswith((" ", "#")):
            skipping = line.startswith(("defaults:", "hydra:", "_target_:", "_partial_:"))
        if not skipping:
            body.append(line)
    return "\n".join(body).strip("\n")


def _what_it_does() -> str:
    return _escaped(_heading(_CONFIGS / f"{HydraConfig.get().job.config_name}.yaml"))


def _has_presets(path: Path) -> bool:
    """Whether a command is a training or a benchmark, which `debug=` and `experiment=` are for."""
    return any("- common" in line for line in _lines(path))


def _groups_of(path: Path) -> set[str]:
    """Groups of the defaults of a command's file."""
    groups: set[str] = set()
    for entry in OmegaConf.load(path).defaults:
        for key in entry if isinstance(entry, DictConfig) else ():
            name, _, package = str(key).removeprefix("optional ").partition("@")
            if package != "_here_" and not name.startswith(("hydra", "override ")):
                groups.add(name)
    return groups


def _groups() -> str:
    command = HydraConfig.get().job.config_name
    path = _CONFIGS / f"{command}.yaml"
    groups = _groups_of(path)
    if _has_presets(path):
        groups |= _groups_of(_CONFIGS / "common.yaml") | {"debug", "experiment"}
    if not groups:
        return ""
    loader = GlobalHydra.instance().config_loader()
    lines = []
    for name in sorted(groups):
        options = loader.get_group_options(name)
        kept = [option for option in options if option not in _NOT_FOR.get(str(command), ())]
        lines.append(f"{name}: {', '.join(kept)}")
    return "\n".join(["== Groups: group=option ==", "", *lines, "", ""])


def _keys() -> str:
    hydra = HydraConfig.get()
    path = _CONFIGS / f"{hydra.job.config_name}.yaml"
    parts = [_body(path)]
    if _has_presets(path):
        parts.append(_body(_CONFIGS / "common.yaml"))
    choices = dict(hydra.runtime.choices)
    for entry in OmegaConf.load(path).defaults:  # Hydra records no choice of several options
        if isinstance(entry, DictConfig):
            choices |= {str(k): v for k, v in entry.items() if isinstance(v, ListConfig)}
    for choice, options in choices.items():
        group, _, package = str(choice).partition("@")
        for option in [options] if isinstance(options, str) else options or []:
            path = _CONFIGS / group / f"{option}.yaml"
            if not group.startswith("hydra") and (body := _body(path)):
                if package != "_global_" and "# @package _global_" not in _lines(path):
                    body = _indented(body, package or group.rpartition("/")[2])
                parts.append(f"# {str(choice).removesuffix('@_global_')}={option}\n{body}")
    return _escaped("\n\n".join(part for part in parts if part))


def _indented(body: str, key: str) -> str:
    return f"{key}:\n  " + body.replace("\n", "\n  ")


def _escaped(text: str) -> str:
    return text.replace("$", "$$")  # Hydra substitutes this text into its own template


def register_resolvers() -> None:
    """Register ``${what_it_does:}``, ``${groups:}`` and ``${keys:}`` for the text of `--help`."""
    OmegaConf.register_new_resolver("groups", _groups, replace=True)
    OmegaConf.register_new_resolver("what_it_does", _what_it_does, replace=True)
    OmegaConf.register_new_resolver("keys", _keys, replace=True)
