"""Inference with a trained network: start-up, washout, smoothing, checkpoints."""

from narx.inference.checkpoint import Checkpoint, load, save
from narx.inference.narx_method import NarxMethod
from narx.inference.predict import Prediction, angles_from_gyroscope, predict
from narx.inference.pretrained import pretrained
from narx.inference.session import SessionPrediction, predict_session
from narx.inference.start_up import StartUp
from narx.inference.stream import Estimate, OrientationStream, Quality
from narx.inference.tracker import PostureTracker

__all__ = [
    "Checkpoint",
    "Estimate",
    "NarxMethod",
    "OrientationStream",
    "PostureTracker",
    "Prediction",
    "Quality",
    "SessionPrediction",
    "StartUp",
    "angles_from_gyroscope",
    "load",
    "predict",
    "predict_session",
    "pretrained",
    "save",
]
