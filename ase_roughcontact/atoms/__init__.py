"""The contact as ASE atoms: calculator, construction, frames."""
