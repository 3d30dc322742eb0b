"""Compute angles from recordings with a trained network: a segment, a leg, or many files.

python -m experiments.predict checkpoint=PATH input=walk.csv output=angles.csv
python -m experiments.predict "input={thigh_right: a.csv, shank_right: b.csv}" output=knee.csv
python -m experiments.predict "input=recordings/*.csv" output=angles
python -m experiments.predict data=study data_root=DIR output=angles
"""

from pathlib import Path

from omegaconf import DictConfig

from narx.errors import UserError
from narx.experiments.command import command
from narx.experiments.predictions.angle_files import check_suffix
from narx.experiments.predictions.bulk import is_bulk, jobs_of_files, run_all
from narx.experiments.predictions.jobs import trial_jobs
from narx.experiments.predictions.partitions import is_partitioned, part_jobs
from narx.experiments.predictions.provenance import write_provenance
from narx.experiments.predictions.session import predict_files, session_files
from narx.experiments.predictions.single import predict_file


def _predict(cfg: DictConfig) -> None:
    target = Path(str(cfg.output))
    if (cfg.input is None) == (not cfg.data):
        raise UserError("input and data: expected one of them, a file or a source of recordings")
    if cfg.format == "motion_bids" and not cfg.data:
        raise UserError(
            "format is 'motion_bids', expected data=study with it, which names subjects and tasks "
            "(narx-draft-study); the output of one recording may end in _motion.tsv"
        )
    if cfg.data:
        run_all(trial_jobs(cfg, target), target, cfg)
        return
    if not isinstance(cfg.input, DictConfig) and is_bulk(str(cfg.input)):
        run_all(jobs_of_files(cfg, target), target, cfg)
        return
    files = session_files(cfg.input) if isinstance(cfg.input, DictConfig) else None
    sources = list(files.values()) if files else [Path(str(cfg.input))]
    for source in sources:
        if target.exists() and source.exists() and target.samefile(source):
            raise UserError(f"output: '{target}' is also the input, expected another name")
    if files is not None and is_partitioned(files, target):
        run_all(part_jobs(cfg, files, target), target, cfg)
        return
    check_suffix(target)
    if files is not None:
        notes = predict_files(cfg, files, target)
    else:
        prediction, n_angles = predict_file(cfg, sources[0], target, cfg.side)
        notes = prediction.notes
        print(*notes, sep="\n")
        print(f"{target}: {n_angles} of {len(prediction.time_s)} samples with angles")
    write_provenance(cfg, target.with_name(f"{target.stem}_record.json"), sources, notes)


main = command("predict", keeps_run=False)(_predict)

if __name__ == "__main__":
    main()
