r"""Contact of a rigid surface with an elastic half space: arrays in, arrays out.

The energy of a displacement :math:`u` under an indenter at height :math:`Z` is

.. math:: U(u, Z) = a_0^2 \left[\tfrac12 \sum u\, K u + \sum V(g)\right], \qquad
          g = Z + h - (u - \langle u \rangle),

summed over the displaced atoms (elastic energy) and the atoms of the window (wall). The
mean :math:`\langle u \rangle` is taken over a periodic cell, and zero for a free half
space. With the pressure :math:`p = -V'(g)` of the wall, the force on an atom and the
normal force on the indenter are

.. math:: f = -\frac{\partial U}{\partial u}
            = -a_0^2 \left[K u + p - \langle p \rangle\right], \qquad
          N = -\frac{\partial U}{\partial Z} = a_0^2 \sum p.
"""

from ase_roughcontact.contact.contact import Contact
from ase_roughcontact.contact.problem import Problem
from ase_roughcontact.contact.state import ContactState, State

__all__ = ["Contact", "ContactState", "Problem", "State"]
