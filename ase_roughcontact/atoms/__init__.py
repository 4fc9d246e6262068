"""The contact problem as ASE atoms: construction, calculator, files and views."""
