r"""Solvers of the contact problem on arrays, without ASE.

The unknowns are the pressure p on the window of atoms, and the height Z of the indenter
where it is free. The pressure widens the gap by a convolution with the Green's
function G of the half space, :math:`g = Z + h + G p`.

===========  =========================================================  ================
``hard``     walls without attraction, a complementarity problem:       `active_set`
             :math:`g \ge 0,\ p \ge 0,\ g p = 0`
``soft``     walls that are functions of the gap, :math:`p = -V'(g)`,   `newton_krylov`
             and hard ones that attract: the minimum of an energy
``lateral``  friction: tractions below their bounds, at a given         `solve_friction`
             pressure
===========  =========================================================  ================

**Hard walls.** `hard.active_set` starts on coarser grids (`coarsening`), crops the
window to the atoms that can touch, and calls `hard.defect_correction` on each grid:
there one exact convolution in an outer step corrects the circulant model of the half
space, for which `hard.complementarity` solves the contact problem.
`hard.starting_pressure` is the first guess, `hard.bounds` keeps pressures between zero
and the hardness, and `hard.linear_support` is the load or spring of the indenter.
`optimality` gives the residuals of the contact conditions for any pressure.

**Soft walls.** `soft.newton` is the outer loop, on coarser grids first. Each step
(`soft.newton_step`, with its line search) solves Newton's equations
(`soft.newton_equations`) by `gcr`, a Krylov method, with the circulant model as
preconditioner. `soft.energy` is the energy with its derivatives, and
`soft.indenter_height` finds heights that carry the load without a convolution.

**Friction.** `lateral.friction` is a semismooth Newton method for the equations of
`lateral.friction_problem`, which `gcr` solves, too. The coupling with the normal
problem is part of the kind of path that slides.

**In common.** `relaxation` has the inputs and results of solvers: each solver is a
generator of `Relaxation`, which a `SolverRelaxer` runs up to the tolerance; the outcome
is a `Run`. `options` are the settings of solvers, `status` is the reason for their end.
For a relaxed state, `response` calculates the derivatives with the height and with
parameters (contact stiffness, fits), and `conductance` the conductance of the contact.
"""
