"""Parameters of a contact from measured force curves."""

SHOWN = {
    "api": {
        "FittedCurve": "series.row",
        "FittedCurves": "series.table",
        "fit_curves": "series.run",
        "read_fitted_curves": "series.run",
    }
}
