"""Compute angles from recordings with a trained network: a segment, a leg, or many files.

python -m experiments.predict checkpoint=PATH input=walk.csv output=angles.csv
python -m experiments.predict "input={thigh_right: a.csv, shank_right: b.csv}" output=knee.csv
python -m experiments.predict "input=recordings/*.csv" output=angles
python -m experiments.predict data=study data_root=DIR output=angles
"""

from collections.abc import Mapping
from pathlib import Path

from omegaconf import DictConfig
from threadpoolctl import threadpool_limits

from narx.errors import UserError
from narx.experiments.command import command
from narx.experiments.free_output import check_free
from narx.experiments.predictions.angle_files import check_suffix
from narx.experiments.predictions.bulk import is_bulk, jobs_of_files, run_all
from narx.experiments.predictions.jobs import trial_jobs
from narx.experiments.predictions.motion_bids_files import (
    ENDING,
    files_beside,
    root_of,
    write_description,
)
from narx.experiments.predictions.options import Kind, refuse_unused
from narx.experiments.predictions.partitions import is_partitioned, part_jobs
from narx.experiments.predictions.provenance import hashes_of, write_provenance
from narx.experiments.predictions.session import (
    files_of_strides,
    predict_files,
    session_files,
)
from narx.experiments.predictions.single import predict_file
from narx.inference.stream import Quality


# a recording's matrices are small: threads that wait for a share of them double the CPU time
@threadpool_limits.wrap(limits=1, user_api="blas")
def _predict(cfg: DictConfig) -> None:
    target = Path(str(cfg.output))
    if (cfg.input is None) == (not cfg.data):
        raise UserError("input and data: expected one of them, a file or a source of recordings")
    if cfg.align != "auto" and (cfg.data or not isinstance(cfg.input, DictConfig)):
        raise UserError(
            f"align is {cfg.align}, which is for input={{SEGMENT: FILE, ...}}; expected auto (a "
            "study has its own align in study.yaml)"
        )
    if cfg.format == "motion_bids" and not cfg.data:
        raise UserError(
            "format is 'motion_bids', expected data= with it, such as data=study, which names "
            "subjects and tasks (narx-draft-study); one recording's output may end in _motion.tsv"
        )
    files = session_files(cfg.input) if isinstance(cfg.input, DictConfig) else None
    kind = _kind(cfg, files, target)
    refuse_unused(cfg, kind)
    if kind == "trials":
        run_all(trial_jobs(cfg, target), target, cfg)
        return
    if kind == "files":
        run_all(jobs_of_files(cfg, target), target, cfg)
        return
    sources = list(files.values()) if files else [Path(str(cfg.input))]
    if files is not None and kind == "parts":
        if cfg.align not in ("auto", "stamps"):
            raise UserError(
                f"align is {cfg.align}, and a session in parts is aligned by its time stamps; "
                "expected auto or stamps"
            )
        run_all(part_jobs(cfg, files, target), target, cfg)
        return
    check_suffix(target)
    # the whole name, since angles.csv and angles.sto may be of different recordings
    record = target.with_name(f"{target.name}_record.json")
    beside = files_of_strides(target) if files else []
    is_bids = target.name.endswith(ENDING)
    written = [target, record, *beside, *(files_beside(target) if is_bids else ())]
    check_free(written, sources)
    if files is not None:
        notes = predict_files(cfg, files, target)
    else:
        prediction, n_angles = predict_file(cfg, sources[0], target, cfg.side)
        notes = prediction.notes
        print(*notes, sep="\n")
        good = int((prediction.quality == Quality.GOOD).sum())
        print(
            f"{target}: {n_angles} of {len(prediction.time_s)} samples with angles, {good} of good "
            "quality (0)"
        )
    # a folder of recordings may hold the angles
    own = {path.resolve() for path in written}
    hashes = hashes_of(sources).items()
    read = {path: digest for path, digest in hashes if Path(path).resolve() not in own}
    if is_bids:
        write_description(root_of(target))
    write_provenance(cfg, record, read, notes)


def _kind(cfg: DictConfig, files: Mapping[str, Path] | None, target: Path) -> Kind:
    """Tell what is to be predicted, from input and output."""
    if cfg.data:
        return "trials"
    if files is not None:
        return "parts" if is_partitioned(files, target) else "session"
    return "files" if is_bulk(str(cfg.input)) else "file"


main = command("predict", keeps_run=False)(_predict)

if __name__ == "__main__":
    main()
