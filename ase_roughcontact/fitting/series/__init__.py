"""Fits of many force curves: maps, and series of files.

=============== ===================================================================
``listing``     the curves in files, folders and archives
``row``         `FittedCurve`, the result for a curve, and its row in a table
``one_curve``   reading and fit of one curve
``run``         `fit_curves`, which fits all in parallel and continues after a stop
``summary``     medians and quartiles, and how many curves failed and why
``grid``        values on the grid of a map
``figures``     maps, a histogram, parameters over the number of the curve
=============== ===================================================================
"""
