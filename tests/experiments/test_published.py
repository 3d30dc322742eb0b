import numpy as np

from narx.experiments.published import published
from narx.kinematics.segment_angles import AXES


def test_tham():
    table = published("tham_tables_2_to_4")
    assert table.groupby("table").size().to_dict() == {2: 9, 3: 9, 4: 6}
    assert table["axis"].unique().tolist() == list(AXES)
    # the text repeats these: sagittal bias and precision, RMSE per speed; transverse r
    narx = table[table["method"] == "narx"].set_index(["axis", "condition"])
    sagittal = narx.loc["sagittal"].loc[["slow", "normal", "fast"]]
    assert sagittal["error_mean_deg"].tolist() == [-0.4, -0.3, -0.3]
    assert sagittal["error_sd_deg"].tolist() == [2.5, 2.2, 2.5]
    assert sagittal["rmse_mean_deg"].tolist() == [3.2, 2.7, 3.6]
    assert narx.loc["transverse"].loc[["slow", "normal", "fast"], "r_mean"].tolist() == [
        0.84, 0.83, 0.84,
    ]  # fmt: skip
    # and the demographics: 26.8 +- 4.2 years, 62.2 +- 16.3 kg
    people = published("tham_table_1")
    np.testing.assert_allclose(
        [people["age_years"].mean(), people["age_years"].std()], [26.8, 4.2], atol=0.05
    )
    np.testing.assert_allclose(
        [people["mass_kg"].mean(), people["mass_kg"].std()], [62.2, 16.3], atol=0.05
    )


def test_han_overall_is_the_mean_of_normal_and_abnormal():
    table = published("han_tables_1_and_2")
    numbers = [c for c in table.columns if c.endswith(("thigh", "shank"))]
    assert len(numbers) == 6
    for _, part in table.groupby(["table", "quantity"]):
        part = part.set_index("condition")[numbers].astype(float)
        mean = (part.loc["normal"] + part.loc["abnormal"]) / 2
        np.testing.assert_allclose(part.loc["overall"], mean, atol=0.0051)


def test_abhayasinghe():
    table = published("abhayasinghe_table_1").set_index("group")
    assert table["n_trials"]["Males"] + table["n_trials"]["Females"] == table["n_trials"]["All"]
    weighted = (196 * table["r_mean"]["Males"] + 178 * table["r_mean"]["Females"]) / 374
    np.testing.assert_allclose(weighted, table["r_mean"]["All"], atol=1e-4)
    assert len(published("abhayasinghe_table_2")) == 7
    assert published("abhayasinghe_table_3")["point"].tolist() == list("abcdef")
    text = published("abhayasinghe_text").set_index("quantity")["value"]
    assert text["rmse_mean_deg"] == 1.8477
