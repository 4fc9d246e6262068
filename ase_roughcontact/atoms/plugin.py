"""Entry point of the plugin system of ASE, which ``ase info --plugins`` lists."""

from __future__ import annotations

from typing import Any

try:
    from ase._4.plugins.plugin import CalculatorPlugin
except ImportError:  # experimental in ASE 3.29, and likely to move
    CalculatorPlugin = None

__ase_plugins__: set[Any] = set()
if CalculatorPlugin is not None:
    __ase_plugins__.add(
        CalculatorPlugin(
            name="roughcontact",
            implementation="ase_roughcontact.atoms.calculator.RoughContact",
        )
    )
