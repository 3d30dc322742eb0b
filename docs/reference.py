"""Write a page for the public names of every room below `api/` when the site is built."""

from importlib import import_module
from pathlib import Path

ROOMS = {
    "recordings": "Recordings",
    "datasets": "Data sets",
    "kinematics": "Kinematics",
    "gait": "Gait",
    "calibration": "Calibration",
    "windows": "Windows",
    "network": "Network",
    "training": "Training",
    "inference": "Inference",
    "baselines": "Baselines",
    "evaluation": "Evaluation",
    "export": "Export",
}


def on_pre_build(config: object) -> None:
    """Hook of MkDocs: the pages are made anew from each room's `__all__`.

    Parameters
    ----------
    config : MkDocsConfig
        Of the site; `docs_dir` holds the pages.
    """
    folder = Path(config["docs_dir"]) / "api"  # type: ignore[index]
    folder.mkdir(exist_ok=True)
    for room, title in ROOMS.items():
        module = import_module(f"narx.{room}")
        lines = [f"# {title}", "", f"`narx.{room}`: {module.__doc__}", ""]
        # by the module that defines it: a module and a function of one name would hide each other
        lines += [f"::: {_home(module, name)}\n" for name in getattr(module, "__all__", ())]
        page = folder / f"{room}.md"
        text = "\n".join(lines)
        if not page.exists() or page.read_text() != text:  # else `mkdocs serve` never rests
            page.write_text(text)


def _home(module: object, name: str) -> str:
    thing = getattr(module, name)
    home = getattr(thing, "__module__", None)
    if not isinstance(home, str) or not home.startswith("narx."):
        home = next(m for m in _submodules(module) if name in vars(import_module(m)))
    return f"{home}.{name}"


def _submodules(module: object) -> list[str]:
    folder = Path(module.__file__).parent  # type: ignore[attr-defined]
    prefix = module.__name__  # type: ignore[attr-defined]
    return [f"{prefix}.{p.stem}" for p in sorted(folder.glob("*.py")) if p.stem != "__init__"]
