import numpy as np
import pandas as pd

from narx.evaluation.comparison import rows
from narx.evaluation.results import results_table
from narx.experiments.tables.overview import overview_table


def test_a_cell_is_the_mean_over_people(make_study):
    results = results_table(row for e in make_study(subjects="ABC") for row in rows(e))
    # a person with more trials than the others counts once
    extra = results[results["subject"] == "A"].assign(trial="again")
    results = pd.concat([results, extra], ignore_index=True)
    results.loc[results["subject"] == "A", "rmse_deg"] += 3.0
    frame = overview_table(results, "rmse_deg").frame
    here = results[results["segment"].str.startswith("knee") & (results["axis"] == "frontal")]
    here = here[here["method"] == "pseudo_integrator"]
    by_person = here.groupby("subject")["rmse_deg"].mean()
    np.testing.assert_allclose(frame.loc[("as printed", "PI"), "knee frontal"], by_person.mean())
    assert abs(by_person.mean() - here["rmse_deg"].mean()) > 0.1
    assert np.isnan(frame.loc[("as printed", "CF"), "knee transverse"])
    assert overview_table(results, "precision_deg").title == "precision (°), mean over 3 subjects"


def test_an_axis_without_numbers_has_no_column(make_study):
    results = results_table(row for e in make_study(subjects="A") for row in rows(e))
    results.loc[results["axis"] == "transverse", "rmse_deg"] = np.nan
    columns = overview_table(results, "rmse_deg").frame.columns
    assert not any("transverse" in name for name in columns)
    assert "knee sagittal" in columns
