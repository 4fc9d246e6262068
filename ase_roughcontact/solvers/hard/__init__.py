"""Hard walls: pressure as the unknown of a complementarity problem."""
