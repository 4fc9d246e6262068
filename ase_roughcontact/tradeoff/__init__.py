"""Accuracy of a calculation against its time."""

SHOWN = {"plot": {"plot_tradeoff": "figures"}}
