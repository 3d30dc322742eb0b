"""The methods compared with the network: every form of each, with default or chosen parameters."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hydra.utils import instantiate
from omegaconf import DictConfig

from narx.datasets.splits import Fold
from narx.errors import MethodNotApplicableError, UserError
from narx.evaluation.trial import Refusal
from narx.experiments.choosing import Prepare, TrainingPart, choose_parameters
from narx.experiments.forms import CHOSEN, forms_of, grid_of
from narx.experiments.gathered import Gathered
from narx.experiments.networks import trainer
from narx.method import OrientationMethod
from narx.training.trial_reader import Stretch

# the network run forwards only, forwards and backwards, and one trained axis by axis as printed
NETWORK_METHODS = frozenset({"narx", "narx_smoothed", "narx_axis_by_axis"})
# the tilt does not depend on the heading's leak, so it is chosen last, on the transverse axis
_HEADING_LEAK = "heading_leak_rad_s"
_TRANSVERSE_ALONE = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Rivals:
    """The rows of a benchmark that are not networks.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        The benchmark's configuration.
    settings : mapping of str to dict
        Settings of every row, with default parameters.
    grids : mapping of str to mapping
        Grid from which the parameters of a row are chosen.
    gathered : Gathered
        Records the chosen parameters.
    """

    cfg: DictConfig
    settings: Mapping[str, Mapping[str, Any]]
    grids: Mapping[str, Mapping[str, list[Any]]]
    gathered: Gathered

    def methods_for(self, fold: Fold, prepare: Prepare) -> dict[str, OrientationMethod]:
        """Create the methods of a fold.

        Parameters
        ----------
        fold : Fold
            Parameters are chosen on its training part; without one, there are only the default
            rows.
        prepare : callable
            Loads and calibrates a trial.

        Returns
        -------
        dict of str to OrientationMethod
            By row; methods with trained weights are trained.

        Raises
        ------
        UserError
            If a method has to be trained and there is no training data.
        """
        methods = {row: _made(settings) for row, settings in self.settings.items()}
        self._fit({row: method for row, method in methods.items() if method.learns}, fold, prepare)
        if not (self.cfg.choose and self.grids and fold.training):
            return methods
        objective = instantiate(self.cfg.model.objective, _convert_="all")
        objective = objective.for_axes(self.cfg.model.coupled)
        training = TrainingPart(
            fold,
            prepare,
            self.cfg.training.skip_s,
        )
        if not training:
            return methods
        known: dict[str, dict[str, Any]] = {}
        for row, grid in self.grids.items():
            settings = dict(self.settings[row])
            tilt = {name: values for name, values in grid.items() if name != _HEADING_LEAK}
            # the tilt of a single segment does not depend on the treatment of its heading
            alike = repr({key: settings[key] for key in settings if not key.startswith("heading")})
            if alike not in known:
                known[alike] = choose_parameters(
                    settings, tilt, training, objective.axis_weights, objective.offset_free
                )
            chosen = dict(known[alike])
            if settings.get("heading") == "leak" and _HEADING_LEAK in grid:
                leaks = {_HEADING_LEAK: grid[_HEADING_LEAK]}
                # the mean error counts: a drift leaves an offset of drift / leak
                chosen |= choose_parameters(
                    settings | chosen, leaks, training, _TRANSVERSE_ALONE, offset_free=False
                )
            name = f"{row}_{CHOSEN}"
            methods[name] = _made(settings | chosen)
            self.gathered.chosen[fold.name, name] = chosen
        return methods

    def _fit(self, methods: Mapping[str, OrientationMethod], fold: Fold, prepare: Prepare) -> None:
        """Train methods with weights like the network: same parts, same teacher, same seed."""
        if not methods:
            return
        parts = (*fold.training, *fold.validation)
        if not parts:
            raise UserError(
                f"methods: {', '.join(methods)} learns, and this split has nothing to train on; "
                "expected one with a training part, such as split=leave_one_subject_out"
            )

        def stretches() -> Iterator[Stretch]:
            for part in parts:
                trial, segments = prepare(part)
                yield Stretch(trial, part.start_s, part.stop_s, segments)

        training = trainer(self.cfg).reader.sequences(stretches())
        begun = time.perf_counter()
        for method in methods.values():
            method.fit(training, self.cfg.training.seed)
        self.gathered.workload.training_s += time.perf_counter() - begun


def rivals_of(cfg: DictConfig, gathered: Gathered) -> Rivals:
    """List the rows requested by a configuration.

    Parameters
    ----------
    cfg : omegaconf.DictConfig
        With `methods`, `method`, `forms`, `choose` and `grid`.
    gathered : Gathered
        Records the methods whose library is not installed.

    Returns
    -------
    Rivals
        Creates the methods of each fold.

    Raises
    ------
    UserError
        If a method is unknown, or one with trained weights has a grid.
    """
    settings: dict[str, Mapping[str, Any]] = {}
    grids: dict[str, Mapping[str, list[Any]]] = {}
    for name in cfg.methods:
        if name in NETWORK_METHODS:
            continue
        if name not in cfg.method:
            known = ", ".join([*sorted(NETWORK_METHODS), *sorted(cfg.method)])
            raise UserError(f"methods: unknown method '{name}', expected some of {known}")
        rows = forms_of(cfg, name)
        try:
            for row in rows.values():
                _made(row)
        except MethodNotApplicableError as error:
            gathered.refusals.append(Refusal("every trial", "every segment", name, str(error)))
            continue
        settings |= rows
        if (grid := grid_of(cfg, name)) and _made(next(iter(rows.values()))).learns:
            raise UserError(f"grid.{name}: its parameters are determined in training")
        if grid:
            grids |= dict.fromkeys(rows, grid)
    if not settings and gathered.refusals and not NETWORK_METHODS & set(cfg.methods):
        raise UserError(gathered.refusals[0].reason)
    return Rivals(cfg, settings, grids, gathered)


def _made(settings: Mapping[str, Any]) -> OrientationMethod:
    method = instantiate(dict(settings), _convert_="all")
    assert isinstance(method, OrientationMethod)
    return method
