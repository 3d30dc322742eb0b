"""Draft a `study.yaml` for a folder of recordings.

python -m experiments.draft_study input=DIR
"""

from pathlib import Path

from omegaconf import DictConfig

from narx.datasets.study import Study
from narx.datasets.study_draft import draft_study
from narx.datasets.study_file import FILE_NAME
from narx.errors import UserError
from narx.experiments.command import command
from narx.files import atomic_path


def _draft(cfg: DictConfig) -> None:
    folder = Path(str(cfg.input)).expanduser()
    target = folder / FILE_NAME
    if target.exists() and not cfg.overwrite:
        raise UserError(f"{target} already exists; overwrite=true replaces it")
    draft = draft_study(folder)
    try:
        with atomic_path(target) as temporary:
            temporary.write_text(draft.text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"{target} cannot be written: {error.strerror}") from error
    print(*draft.guesses, sep="\n")
    index = Study(root=folder).index()
    n = len(index)
    print(f"{target}: {n} trial{'s' * (n != 1)}; check the names and edit the file")
    for row in index.itertuples(index=False):
        print(f"  {row.subject}/{row.condition}/{row.trial}: {row.segments}")


main = command("draft_study", keeps_run=False)(_draft)

if __name__ == "__main__":
    main()
