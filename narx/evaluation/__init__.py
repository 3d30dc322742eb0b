"""Comparison of estimates with the reference: agreement, significance, drift, tables."""

from narx.evaluation.agreement import (
    Agreement,
    LimitsOfAgreement,
    agreement,
    limits_of_agreement,
    repeated_limits_of_agreement,
)
from narx.evaluation.comparison import Evaluated
from narx.evaluation.drift import DriftTest, drift_test
from narx.evaluation.results import read_results, results_table
from narx.evaluation.significance import MeanInterval, PairedTest, bootstrap_mean, paired_test
from narx.evaluation.trial import evaluate_trial

__all__ = [
    "Agreement",
    "DriftTest",
    "Evaluated",
    "LimitsOfAgreement",
    "MeanInterval",
    "PairedTest",
    "agreement",
    "bootstrap_mean",
    "drift_test",
    "evaluate_trial",
    "limits_of_agreement",
    "paired_test",
    "read_results",
    "repeated_limits_of_agreement",
    "results_table",
]
