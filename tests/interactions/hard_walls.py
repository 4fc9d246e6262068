"""Hard walls with an attraction of one work and range."""

from ase_roughcontact import DugdaleWall, ExponentialWall, PowerLawWall

W, D = 0.05, 0.7
HARD_WALLS = {
    "dugdale": DugdaleWall(W, D),
    "sharp": DugdaleWall(W, D, relative_taper=0.0),
    "exponential": ExponentialWall(W, D),
    "power-law": PowerLawWall(W, D),
    "van der Waals": PowerLawWall(W, D, exponent=2.0, relative_cutoff=40.0),
}
