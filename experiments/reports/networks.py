"""Text and figure describing a trained network."""

import numpy as np
from matplotlib.figure import Figure

from narx.experiments.figures.training import training_figure
from narx.inference.checkpoint import Checkpoint


def about_network(fold: str, network: Checkpoint) -> str:
    """Describe in one sentence how a network was trained.

    Parameters
    ----------
    fold : str
        Name of the fold that it was trained for.
    network : Checkpoint
        Network, with or without a training report in its history.

    Returns
    -------
    str
        Training data, starts and held-out error, or the origin of the network.
    """
    history = network.history
    if "report" not in history:
        return f"Network of fold {fold}: {history.get('description', 'from a checkpoint')}."
    restarts = history["report"]["restarts"]
    return (
        f"Network of fold {fold}: trained on {history['training_s']:.0f} s of "
        f"{len(history['trained_on'])} segments; {restarts['restarts']:.0f} starts, "
        f"{restarts['dropped']:.0f} dropped, held-out error "
        f"{restarts['validation_rmse_best_deg']:.2f} deg (median of starts "
        f"{restarts['validation_rmse_median_deg']:.2f}, worst "
        f"{restarts['validation_rmse_worst_deg']:.2f})."
    )


def training_history_figure(network: Checkpoint, title: str) -> Figure:
    """Draw the training history of the best start of a network.

    Parameters
    ----------
    network : Checkpoint
        Network with a training report in its history.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib.figure.Figure
        Cost, damping and gradient, as far as the optimizer recorded them.
    """
    history = network.history["report"]["history"]
    names = list(history[0]) if history else []
    return training_figure(
        {name: [entry.get(name, np.nan) for entry in history] for name in names},
        title=f"Training on {title}, best start",
    )
