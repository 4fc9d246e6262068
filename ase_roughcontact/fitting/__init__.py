"""Parameters of a contact from measured force curves."""

SHOWN = {
    "api": {
        "FittedCurve": "series.row",
        "fit_curves": "series.run",
        "read_fitted_curves": "series.run",
    }
}
