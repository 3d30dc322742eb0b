import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from narx.errors import UserError
from narx.evaluation.results import (
    COLUMNS,
    NAMES,
    NUMBERS,
    read_results,
    results_table,
    write_results,
)

name = st.text(
    st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=8
) | st.sampled_from(["01", "NA", "nan", "1e5", 'a,"b', "True"])
number = st.floats(allow_infinity=False)


@st.composite
def row(draw):
    row = {key: draw(name) for key in NAMES}
    row["axis"] = draw(st.sampled_from(["sagittal", "frontal", "transverse"]))
    row["n_samples"] = draw(st.integers(0, 10**9))
    row |= {key: draw(number) for key in NUMBERS}
    row["r"] = draw(st.floats(-1, 1) | st.just(np.nan))
    return row | {key: abs(row[key]) for key in ("precision_deg", "rmse_deg")}


@given(st.lists(row(), max_size=6))
@settings(max_examples=100, deadline=None)
def test_read_results_equal_written_ones(tmp_path_factory, table):
    path = tmp_path_factory.mktemp("results") / "results.csv"
    results = results_table(table)
    write_results(results, path)
    pd.testing.assert_frame_equal(read_results(path), results, check_exact=True)


HEADER = ",".join(COLUMNS)
GOOD = "d,01,normal,1,knee_right,sagittal,narx,10,1.0,2.0,3.0,0.9,-1.0,2.0"


def written(tmp_path, line, header=HEADER):
    path = tmp_path / "results.csv"
    path.write_text(f"{header}\n{line}\n")
    return path


def test_a_good_line(tmp_path):
    table = read_results(written(tmp_path, GOOD))
    assert table["subject"].iloc[0] == "01"
    assert table["n_samples"].iloc[0] == 10
    assert table["r"].iloc[0] == 0.9


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (GOOD.replace("sagittal", "saggital"), "row 1: axis is 'saggital'"),
        (GOOD.replace(",10,", ",ten,"), "row 1: n_samples is 'ten', expected a count"),
        (GOOD.replace(",10,", ",-1,"), "n_samples is '-1'"),
        (GOOD.replace("0.9", "1.9"), "r is '1.9', expected a correlation or nothing"),
        (GOOD.replace("3.0", "-3.0"), "rmse_deg is '-3.0', expected degrees or nothing"),
        (GOOD.replace("3.0", "-"), "rmse_deg is '-'"),
        (GOOD.replace(",2.0,3", ",-2.0,3"), "precision_deg is '-2.0'"),
        (GOOD[:30], "row 1: axis is 'sagit', expected one of"),
        (GOOD + ",7,8", "cannot be read as CSV|axis is"),
    ],
)
def test_a_bad_line_is_named(tmp_path, line, message):
    path = written(tmp_path, f"{GOOD}\n{line}" if "cannot" in message else line)
    with pytest.raises(UserError, match=message) as error:
        read_results(path)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)


def test_a_missing_column_a_missing_file_and_an_empty_one(tmp_path):
    path = written(tmp_path, GOOD, HEADER.replace("rmse_deg", "rmse"))
    with pytest.raises(UserError, match=r"header is .*rmse,r.* expected 'dataset"):
        read_results(path)
    with pytest.raises(UserError, match="nothing_here"):
        read_results(tmp_path / "nothing_here.csv")
    path.write_text("")
    with pytest.raises(UserError, match="cannot be read as CSV"):
        read_results(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UserError, match=r"results\.csv"):
        read_results(path)


def test_a_table_that_is_cut_anywhere_in_its_last_row_is_refused(tmp_path):
    path = tmp_path / "results.csv"
    row = "d,S1,normal,t,thigh_right,sagittal,narx,100,0.5,1.0,1.1,0.9,-1.0,2.0,3.0"
    header = ",".join(COLUMNS) + "\n"
    for length in range(1, len(row) + 1):
        path.write_text(header + row[:length])
        with pytest.raises(UserError, match=r"results\.csv"):
            read_results(path)
    path.write_text(f"{header}{row}\n")
    assert read_results(path)["lag_ms"].tolist() == [3.0]
