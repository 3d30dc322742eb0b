"""Values printed in the papers; the README in this folder gives their tables and pages."""

from importlib import resources

import pandas as pd


def published(name: str) -> pd.DataFrame:
    """Read a table of printed values.

    Parameters
    ----------
    name : str
        Name of the file without ``.csv``, such as ``tham_tables_2_to_4``.

    Returns
    -------
    pandas.DataFrame
        Columns as in the file.
    """
    with resources.files(__name__).joinpath(f"{name}.csv").open(encoding="utf-8") as stream:
        return pd.read_csv(stream, keep_default_na=False)
