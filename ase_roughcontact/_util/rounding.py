"""Rounding errors of given numbers, such as targets, times and lengths."""

#: Relative difference of two targets or times that counts as rounding.
ROUNDING = 1e-12
#: Difference of ratios of lengths, such as to a whole number, that counts as rounding.
RATIO_ROUNDING = 1e-6
#: Difference of two lengths that counts as rounding, relative or in spacings.
LENGTH_ROUNDING = 1e-9
