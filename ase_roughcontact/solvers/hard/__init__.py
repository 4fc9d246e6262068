"""Hard walls: pressure and gap of a complementarity problem."""
