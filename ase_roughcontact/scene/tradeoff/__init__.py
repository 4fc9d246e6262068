"""What accuracy costs in a scene of one's own, and which settings to take for it.

A few steps of the scene are calculated with one setting after the other, and compared
with the same steps calculated far more accurately.
"""

from ase_roughcontact.scene.tradeoff.results import Choice, Tradeoff, Trial
from ase_roughcontact.scene.tradeoff.study import tradeoff

__all__ = ["Choice", "Tradeoff", "Trial", "tradeoff"]
